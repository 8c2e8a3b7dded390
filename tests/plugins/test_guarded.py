"""An error that leaves a component says which one it is, and stays the error it is."""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import pytest

from tacos_framework.errors import Fault, UserError
from tacos_framework.plugins.guarded import Culprit, calling, culprit_of


def test_an_error_passes_unchanged_with_one_note():
    error = ZeroDivisionError("by hand")
    with (
        pytest.raises(ZeroDivisionError) as raised,
        calling("sensor.acme", "acme-cameras", "expose in node 'frames'"),
    ):
        raise error
    assert raised.value is error
    assert error.__notes__ == ["in sensor.acme of acme-cameras, expose in node 'frames'"]
    assert error.__cause__ is None


def test_the_innermost_component_is_to_blame():
    with (
        pytest.raises(KeyError) as raised,
        calling("sensor.acme", "acme"),
        calling("effect.dim", None, "apply"),
    ):
        raise KeyError("k1")
    assert culprit_of(raised.value) == Culprit("effect.dim", None, "apply")
    assert raised.value.__notes__ == ["in effect.dim, apply"]


def test_whoever_is_to_blame_is_known_in_other_processes_too():
    with (
        ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool,
        pytest.raises(UserError) as raised,
    ):
        pool.submit(_blame_acme).result()
    assert culprit_of(raised.value) == Culprit("task.acme", "acme")


def _blame_acme():
    with calling("task.acme", "acme"):
        raise UserError(Fault("acme.csv", "is not there"))


@pytest.mark.parametrize("error", [KeyboardInterrupt(), GeneratorExit()])
def test_what_is_no_fault_of_a_component_is_left_alone(error):
    with pytest.raises(type(error)), calling("task.acme", "acme"):
        raise error
    assert culprit_of(error) is None
