"""Closures on what the selection did not see, and a negative control that selects too."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from typing import Any, ClassVar

import numpy as np
import pytest

from tacos_framework.settings import Settings, setting
from tacos_gap.attribution import Attribution
from tacos_gap.attribution.fits import Fits
from tacos_gap.attribution.held_out import held_out
from tacos_gap.attribution.negative_control import negative_control
from tacos_gap.evidence import Label
from tacos_gap.hypotheses.parameters import HypothesisTerm
from tacos_gap.inference.closure import closure
from tacos_gap.inference.problem import Problem
from tacos_gap.inference.screening import ScreeningDirection

WRONG = 35
COUNT = 24


@cache
def direction(which: int, seed: int) -> np.ndarray:
    return np.random.default_rng((which, seed)).normal(0, 1, COUNT)


class Anything:
    """An effect that changes numbers by a pattern of its own."""

    class Config(Settings):
        height: float = setting(0.0, help="Height.")
        which: str = setting("0", help="Pattern.")

    neutral: ClassVar = {"height": 0.0}

    def __init__(self, config: Config) -> None:
        self.config = config


class Numbers:
    """Evidence: numbers without a pattern, and some of a pattern."""

    def __init__(self, seed: int, true: float, shown: bool = True):
        rng = np.random.default_rng((77, seed))
        self._shown = shown
        self._seed = seed
        self.labels = [Label(f"flat {seed}", "flat", "curve", "optics", {"n": n}) for n in range(COUNT)]
        self.null_replicates = rng.normal(0, 1, (16, COUNT))
        self._real = rng.normal(0, 3, COUNT) + true * shown * direction(0, seed)

    def residual(self, effects: Sequence[Any], draws: int = 1) -> np.ndarray:
        heights = ((e.config.height * self._shown, int(e.config.which)) for e in effects)
        return self._real - sum((h * direction(w, self._seed) for h, w in heights), np.zeros(COUNT))


def selected(first_seed: int, true: float = 0.0, shown: Sequence[bool] = (True, True)) -> Attribution:
    """The best of many effects on two captures, as the selection scores them."""
    evidence: Any = [Numbers(first_seed + k, true, each) for k, each in enumerate(shown)]
    fits = Fits(Problem(evidence))
    terms = [
        HypothesisTerm(f"effect {k}", Anything, {"height": 1.0, "which": str(k)}, {"height": 1.0})
        for k in range(WRONG)
    ]
    ended = fits.fitted([(term,) for term in terms], near=fits.null)
    best = max(ended, key=lambda fitted: fitted.score)
    changes = {term.name: fits.problem.residual((term,)) for term in terms}
    found = Attribution.among(best, fits.null, {}, fits.known, fits.problem)
    return replace(found, directions=directions_of(terms, changes, fits.problem))


def directions_of(terms: Sequence[HypothesisTerm], changed: dict[str, Any], of: Problem) -> Any:
    return {term.name: [ScreeningDirection(term, changed[term.name] - of.null)] for term in terms}


def closed(of: Problem, left: np.ndarray) -> float:
    return closure(of.gap(of.null), float(np.sqrt(np.mean(left**2)) / of.noise_floor_rms))


def test_a_wrong_best_of_many_closes_no_more_than_the_control_that_chose_too():
    seen, unseen, controls = [], [], []
    for trial in range(12):
        found = selected(10 * trial)
        own = closed(found.problem, held_out(found).left)
        control = negative_control(found, own, np.random.default_rng(trial))
        assert control is not None
        assert (control.effects, control.among) == (1, WRONG)
        seen.append(closed(found.problem, found.best.held_out))
        unseen.append(own)
        controls.append(control)
    assert np.median(seen) > 0.05, "the folds that chose it flatter it"
    assert np.median(unseen) < 0.02
    within = [own <= control.interval[1] for own, control in zip(unseen, controls, strict=True)]
    assert np.mean(within) >= 0.75
    assert np.median([control.closure for control in controls]) < 0.02


def test_a_true_effect_closes_more_than_every_control():
    found = selected(0, true=9.0)
    assert found.best.names == ("effect 0",)
    held = held_out(found)
    own = closed(found.problem, held.left)
    control = negative_control(found, own, np.random.default_rng(0))
    assert control is not None
    assert control.p_value == pytest.approx(1 / 65)
    assert own > 0.5
    assert held.why_not("effect 0") == ""


def test_what_one_half_would_not_choose_is_not_held_out_and_says_so():
    found = next(f for f in map(selected, range(0, 200, 10)) if held_out(f).why_not(f.best.names[0]))
    assert (
        held_out(found).why_not(found.best.names[0]).startswith("half of the captures alone chooses effect")
    )


def test_what_one_half_does_not_show_is_not_held_out_and_says_so():
    found = selected(0, true=9.0, shown=(True, False))
    assert found.best.names == ("effect 0",)
    assert "does not show it" in held_out(found).why_not("effect 0")


def test_where_nothing_was_explained_there_is_nothing_to_control():
    found = selected(0)
    nothing = replace(found, best=found.null)
    assert negative_control(nothing, 0.0, np.random.default_rng(0)) is None
    assert held_out(nothing).chosen == ()
