"""How optimizers stand: medians over runs, ratios, and runs that are served together."""

from __future__ import annotations

import math
import os
import signal
import threading
import time
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tacos_validation.optimizers_compared.standings import JudgedRun, Ratio, quartiles, ratio, standings
from tacos_validation.optimizers_compared.together import FilledTogether, together


def a_run(*fitness: float) -> JudgedRun:
    at = [10 * 2**i for i in range(len(fitness))]
    return JudgedRun("x", 0, {each: each for each in at}, dict(zip(at, fitness, strict=True)))


@settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.lists(st.floats(-10, 10), min_size=1, max_size=12))
def test_quartiles_are_numpys(values):
    found = quartiles(values)
    np.testing.assert_allclose(
        (found.low, found.median, found.high), np.quantile(values, [0.25, 0.5, 0.75]), atol=1e-12
    )


def test_what_half_of_the_runs_never_reach_is_never_reached():
    assert math.isinf(quartiles([1.0, 2.0, math.inf, math.inf]).median)
    assert quartiles([1.0, 2.0, 3.0, math.inf]).median == 2.5


def test_the_target_is_reached_at_the_first_checkpoint_that_is_as_good():
    assert a_run(-math.inf, 0.5, 0.4, 0.9).images_to(0.5) == 20
    assert math.isinf(a_run(0.1, 0.2).images_to(0.5))


def test_standings_are_medians_over_runs():
    runs = {"x": [a_run(0.1, 0.6), a_run(0.7, 0.7), a_run(0.1, 0.2)], "y": [replace(a_run(0.2, 0.2))] * 3}
    first, second = standings(
        runs,
        target=0.6,
        best_known=1.0,
        against={"y": math.inf},
        budgets={"x": 20, "y": 660},
        thought_ms={"x": 1.0, "y": 2.0},
    )
    assert (first.optimizer, second.optimizer) == ("x", "y")
    assert first.images.median == 20
    assert first.reached == pytest.approx(2 / 3)
    assert first.regret[10].median == pytest.approx(0.9)
    assert first.ratios["y"] == Ratio(33.0, at_least=True)
    assert second.ratios["y"] == Ratio(None)


def test_a_ratio_to_what_was_reached_is_exact():
    assert ratio(2064, 160, 5000) == Ratio(12.9)


def test_what_fails_for_one_run_ends_all_that_wait():
    class Broken:
        def lacking(self, wanted):
            return list(wanted)

        def fill(self, wanted):
            raise RuntimeError("no light")

    filled = FilledTogether(Broken(), 3)
    with pytest.raises(RuntimeError, match="no light"):
        together([1, 2, 3], lambda member: filled.fill([({"width": member}, None)]), filled)


def test_runs_that_wait_are_served_in_one_batch_and_those_that_end_hold_up_nobody():
    batches = []

    class Table:
        def lacking(self, wanted):
            return list(wanted)

        def fill(self, wanted):
            batches.append([values["width"] for values, _ in wanted])

    filled = FilledTogether(Table(), 3)

    def asks_as_often_as_its_number(member):
        for _ in range(member):
            filled.fill([({"width": member}, None)])

    together([1, 2, 3], asks_as_often_as_its_number, filled)
    assert batches == [[1, 2, 3], [2, 3], [3]]


def test_what_fails_in_one_run_ends_the_others_and_is_told():
    class Table:
        def lacking(self, wanted):
            return list(wanted)

        def fill(self, wanted):
            raise AssertionError("one of the members does not wait")

    filled = FilledTogether(Table(), 3)

    def go(member):
        if member == 2:
            raise ValueError("member 2 is wrong")
        filled.fill([({"width": member}, None)])

    with pytest.raises(ValueError, match="member 2 is wrong"):
        together([1, 2, 3], go, filled)


def test_ctrl_c_leaves_a_batch_at_once_and_keeps_what_had_come():
    kept = []

    class Slow:
        def lacking(self, wanted):
            return [pair for pair in wanted if pair not in kept]

        def fill(self, wanted):
            first, *_ = wanted
            kept.append(first)
            threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT)).start()
            time.sleep(20)

    filled = FilledTogether(Slow(), 2)
    began_s = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        together([1, 2], lambda member: filled.fill([({"width": member}, None)]), filled)
    assert time.monotonic() - began_s < 5
    assert kept == [({"width": 1}, None)]
    assert not [thread for thread in threading.enumerate() if thread.name.startswith("ThreadPoolExecutor")]
