"""Evidence in other processes: the same answers, errors that arrive, and no process left behind."""

from __future__ import annotations

import gc
import os
import signal
from collections.abc import Sequence
from functools import partial
from operator import attrgetter
from typing import Any, ClassVar

import numpy as np
import pytest

from tacos_framework import EffectBase, Settings, UserError, culprit_of, setting
from tacos_framework.plugins import Plugins
from tacos_gap.answer.diagnosis import diagnose
from tacos_gap.captures import CaptureFolder, RealCapture
from tacos_gap.evidence import ImageEvidence, PictureEvidence
from tacos_gap.evidence.elsewhere import EvidenceProcess, measured, of_each, processes_beside, ready
from tacos_gap.evidence.keeper import Job, Keeper, Kept
from tacos_gap.hypotheses.candidates import candidates
from tacos_gap.hypotheses.parameters import HypothesisTerm
from tacos_gap.inference.problem import Problem
from tests.gap.taken import capture, effect, taken

CONSIDERED = {"vignetting", "read-noise", "black-level", "gamma"}


class Spoilt(EffectBase):
    """An effect that fails as it acts."""

    class Config(Settings):
        amount: float = setting(0.0, help="Amount.")

    stage = "readout"
    neutral: ClassVar = {"amount": 0.0}
    initial_guesses: ClassVar = ({"amount": 1.0},)

    def __init__(self, config: Config) -> None:
        self.config = config

    def on_array(self, samples: Any, **_: Any) -> Any:
        """Fail."""
        raise ZeroDivisionError("spoilt")


@pytest.fixture(scope="module")
def captures(plugins: Plugins) -> list[RealCapture]:
    expected = [capture("dark", 0.0), capture("flat", 60.0), capture("flat", 150.0), capture("flat", 220.0)]
    return taken(expected, [effect(plugins, "vignetting", k1=-0.3)])


@pytest.fixture(scope="module")
def process() -> EvidenceProcess:
    (one,) = ready(processes_beside(1, [Spoilt]))
    return one


def evidence_of(seed: int, one: RealCapture) -> PictureEvidence:
    return ImageEvidence(one, seed, replicates=4).renuisanced(())


def test_a_diagnosis_is_the_same_to_the_bit_in_one_process_and_in_three(
    plugins: Plugins, captures: list[RealCapture]
) -> None:
    known = {name: cls for name, cls in candidates(plugins).effects.items() if name in CONSIDERED}
    alone, spread = (
        diagnose(CaptureFolder(None, tuple(captures)), known, seed=3, workers=workers) for workers in (1, 3)
    )
    assert [cause.effect for cause in alone.causes] == ["vignetting"]
    assert alone.as_data() == spread.as_data()
    assert np.array_equal(alone.problem.null, spread.problem.null)
    places = {type(each).__name__ for each in spread.problem.evidence}
    assert places == {"ImageEvidence", "EvidenceElsewhere"}


def test_evidence_elsewhere_answers_as_evidence_here(
    plugins: Plugins, captures: list[RealCapture], process: EvidenceProcess
) -> None:
    function = partial(evidence_of, 1)
    here = [function(each) for each in captures]
    there = measured(function, captures, [process])
    placed = [effect(plugins, "vignetting", k1=-0.2)]
    for one, other in zip(here, there, strict=True):
        assert one.labels == other.labels
        assert one.left_out == other.left_out
        assert one.nuisances(placed) == other.nuisances(placed)
        assert one.pose(placed) == other.pose(placed)
        for name in ("real", "sigma", "null_replicates"):
            assert np.array_equal(getattr(one, name), getattr(other, name))
        assert np.array_equal(one.residual(placed, 2), other.residual(placed, 2))
        assert np.array_equal(one.replicate_residuals(placed).z, other.replicate_residuals(placed).z)
        moved = [each.renuisanced(placed).agreeing({}).residual(placed) for each in (one, other)]
        assert np.array_equal(*moved)
        assert other.agreeing({}) is other


def test_what_an_effect_raises_elsewhere_arrives_with_its_culprit_and_the_process_goes_on(
    captures: list[RealCapture], process: EvidenceProcess
) -> None:
    problem = Problem(measured(partial(evidence_of, 1), captures, [process]))
    spoilt = HypothesisTerm("spoilt", Spoilt, {"amount": 1.0}, {"amount": 1.0})
    with pytest.raises(ZeroDivisionError, match="spoilt") as raised:
        problem.residual((spoilt,))
    culprit = culprit_of(raised.value)
    assert culprit is not None
    assert culprit.use == "effect.spoilt"
    assert problem.residual(()) is not None


def test_an_effect_that_fails_in_any_process_is_left_out_of_the_diagnosis(
    plugins: Plugins, captures: list[RealCapture]
) -> None:
    known = {"vignetting": candidates(plugins).effects["vignetting"], "spoilt": Spoilt}
    found = diagnose(CaptureFolder(None, tuple(captures)), known, seed=3, workers=2)
    assert [cause.effect for cause in found.causes] == ["vignetting"]
    assert any("spoilt" in text for text in found.limitations)


def test_a_process_that_was_killed_is_named_with_what_to_do(captures: list[RealCapture]) -> None:
    (process,) = ready(processes_beside(1, []))
    found = measured(partial(evidence_of, 1), captures, [process])
    os.kill(process.pid, signal.SIGKILL)
    with pytest.raises(UserError, match=r"SIGKILL \(most often because memory ran out\)(.|\n)*workers: 1"):
        of_each(attrgetter("real"), found)


def test_classes_that_cannot_travel_leave_the_diagnosis_in_one_process(
    plugins: Plugins, captures: list[RealCapture]
) -> None:
    class Local(Spoilt):
        """An effect that no other process can import."""

    known = {"vignetting": candidates(plugins).effects["vignetting"], "local": Local}
    assert processes_beside(1, list(known.values())) == []
    found = diagnose(CaptureFolder(None, tuple(captures)), known, seed=3, workers=2)
    assert [cause.effect for cause in found.causes] == ["vignetting"]


def test_a_class_that_is_nowhere_to_be_imported_from_shows_as_the_process_starts() -> None:
    unknown = type("Unknown", (), {"__module__": __name__})
    globals()["Unknown"] = unknown  # so that it can be pickled here
    assert ready(processes_beside(1, [unknown])) == []


def test_a_process_ends_with_the_last_evidence_it_keeps(captures: list[RealCapture]) -> None:
    (process,) = ready(processes_beside(1, []))
    pid = process.pid
    found = measured(partial(evidence_of, 1), captures, [process])
    del process
    gc.collect()
    assert of_each(attrgetter("real"), found)
    del found
    gc.collect()
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)


def test_a_keeper_forgets_what_nobody_asks_for_again() -> None:
    keeper = Keeper(())

    class Known(PictureEvidence):
        labels: Sequence[Any] = ()

    Known.__abstractmethods__ = frozenset()
    (first,) = keeper(Job(lambda _: Known(), ["a capture"]))
    assert first == Kept(1, ())
    assert keeper(Job(lambda each: each, [1])) == [Kept(1, None)]
    assert keeper(Job(lambda _: Known(), [1])) == [Kept(2, None)]
    assert keeper(Job(lambda each: type(each).__name__, [2], forgotten=[1])) == ["Known"]
    with pytest.raises(KeyError):
        keeper(Job(lambda each: each, [1]))
