"""Two effects that are there, and a third that by itself does more than either."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np
import pytest

from tacos_framework.formation import PlacedEffect
from tacos_framework.settings import Settings, setting
from tacos_gap.attribution import ForwardSelection
from tacos_gap.attribution.pairs import best_pair
from tacos_gap.evidence import Label, ReplicateResiduals
from tacos_gap.inference.problem import Problem
from tacos_gap.inference.screening import try_all

PLACES = 120
PATTERNS = np.random.default_rng(3).normal(size=(4, PLACES))
GRADIENT, RIPPLE, *_ = PATTERNS
LEANING = 0.5 * (GRADIENT + RIPPLE) + 0.25 * PATTERNS[2], 0.2 * GRADIENT - 0.2 * RIPPLE + 0.3 * PATTERNS[3]
"""What the third effect can do with its two parameters: most of both, and none of them exactly."""


class Gradient:
    class Config(Settings):
        amount: float = setting(0.0, help="How much.", ge=-100, le=100)

    stage: ClassVar = "exposure"
    neutral: ClassVar = {"amount": 0.0}
    initial_guesses: ClassVar = ({"amount": 2.0},)
    patterns: ClassVar = (GRADIENT,)

    def __init__(self, config: Any) -> None:
        self.config = config


class Ripple(Gradient):
    """Another."""

    patterns: ClassVar = (RIPPLE,)


class Leaning(Gradient):
    """Leans towards both."""

    class Config(Settings):
        amount: float = setting(0.0, help="How much.", ge=-100, le=100)
        more: float = setting(0.0, help="How much of the rest.", ge=-100, le=100)

    neutral: ClassVar = {"amount": 0.0, "more": 0.0}
    initial_guesses: ClassVar = ({"amount": 2.0}, {"more": 2.0})
    patterns: ClassVar = LEANING


EFFECTS: dict[str, type[Any]] = {"gradient": Gradient, "ripple": Ripple, "leaning": Leaning}


class Field:
    """Evidence of numbers at places, in which effects add their patterns up."""

    def __init__(self, real: np.ndarray):
        rng = np.random.default_rng(0)
        self.real = real + rng.normal(size=PLACES)
        self.null_replicates = rng.normal(size=(64, PLACES))
        self.labels = [Label("flat", "flat", f"part {i // 40}", "exposure", {}) for i in range(PLACES)]

    def residual(self, effects: Sequence[PlacedEffect], draws: int = 1) -> np.ndarray:
        expected = np.zeros(PLACES)
        for effect in effects:
            amounts = effect.config.model_dump().values()
            expected += sum(a * p for a, p in zip(amounts, effect.cls.patterns, strict=True))
        return np.asarray(self.real - expected)

    def replicate_residuals(self, effects: Sequence[PlacedEffect]) -> ReplicateResiduals:
        return ReplicateResiduals(self.residual(effects), self.null_replicates, np.ones(PLACES))


def problem(gradient: float, ripple: float) -> Problem:
    return Problem([Field(gradient * GRADIENT + ripple * RIPPLE)])  # type: ignore[list-item]


def test_the_two_that_are_there_are_named_and_not_the_one_that_leans_towards_both():
    told: list[str] = []
    found = ForwardSelection(problem(4.0, 3.0), EFFECTS, notify=told.append).run()
    assert sorted(found.best.names) == ["gradient", "ripple"]
    both = {f"looking beside {first}" for first in ("gradient + ripple", "ripple + gradient")}
    assert told[0] in both  # at once, and not by way of the third
    amounts = {term.name: term.values["amount"] for term in found.best.hypothesis}
    assert amounts == {"gradient": pytest.approx(4.0, abs=0.3), "ripple": pytest.approx(3.0, abs=0.3)}


@pytest.mark.parametrize(("simulations", "names"), [(1, []), (2000, ["gradient", "ripple"])])
def test_a_search_ends_where_its_simulations_are_spent_and_says_so(simulations, names):
    found = ForwardSelection(problem(4.0, 3.0), EFFECTS, simulations=simulations).run()
    assert sorted(found.best.names) == names
    assert found.cut_short == (names == [])


def test_simulations_of_a_search_before_do_not_count():
    """As of one that was broken off since an effect raised."""
    of = problem(4.0, 3.0)
    first = ForwardSelection(of, EFFECTS).run()
    assert of.simulations > 20
    again = ForwardSelection(of, EFFECTS, simulations=of.simulations).run()
    assert sorted(again.best.names) == sorted(first.best.names)
    assert not again.cut_short


def test_by_itself_the_third_does_more_than_either():
    of = problem(4.0, 3.0)
    alone = {name: ForwardSelection(of, {name: cls}).run().best.score for name, cls in EFFECTS.items()}
    assert max(alone, key=lambda name: alone[name]) == "leaning"


@pytest.mark.parametrize("name", ["gradient", "ripple"])
def test_one_that_is_there_alone_is_named_alone(name):
    found = ForwardSelection(problem(4.0 * (name == "gradient"), 4.0 * (name == "ripple")), EFFECTS).run()
    assert found.best.names == (name,)


def test_a_pair_begins_where_both_together_leave_least():
    of = problem(4.0, 3.0)
    pair = best_pair(try_all(of, EFFECTS), ["gradient", "ripple"], of.null)
    assert pair is not None
    assert [term.values["amount"] for term in pair.terms] == pytest.approx([4.0, 3.0], abs=0.3)


def test_one_effect_is_no_pair():
    of = problem(4.0, 0.0)
    assert best_pair(try_all(of, EFFECTS), ["gradient"], of.null) is None
