"""Which effects an explanation can do without, by first order and once it is fitted to its end."""

from __future__ import annotations

from typing import ClassVar

import pytest

from tacos_gap.attribution import ForwardSelection
from tacos_gap.attribution.needed import hardly_needed, is_plainly_needed, opens_again
from tacos_gap.attribution.selection_rule import COMPLEXITY_PENALTY, LEAST_OF_REST, is_worth_it, least_gain
from tacos_gap.hypotheses.parameters import HypothesisTerm
from tacos_gap.inference.fit import Fitted, finished, fit
from tacos_gap.inference.problem import Problem
from tests.gap.attribution.test_pairs import EFFECTS, GRADIENT, PLACES, RIPPLE, Field, Gradient, problem


class Shadow(Gradient):
    """Takes much of one pattern away, and some of another."""

    patterns: ClassVar = (-0.8 * GRADIENT - 0.6 * RIPPLE,)


def fitted(of: Problem, **amounts: float) -> Fitted:
    terms = tuple(
        HypothesisTerm(name, EFFECTS[name], {"amount": amount}, {"amount": 1.0})
        for name, amount in amounts.items()
    )
    begun = fit(of, terms)
    assert begun is not None
    return finished(of, begun)


@pytest.mark.parametrize(("ripple", "is_needed"), [(4.0, True), (0.0, False)])
def test_what_others_cannot_make_up_for_is_plainly_needed(ripple, is_needed):
    of = problem(4.0, ripple)
    both = fitted(of, gradient=3.0, ripple=1.0)
    assert is_plainly_needed(of, both, "gradient", COMPLEXITY_PENALTY)
    assert is_plainly_needed(of, both, "ripple", COMPLEXITY_PENALTY) is is_needed
    assert is_worth_it(of, fitted(of, gradient=3.0), both) is is_needed


def test_an_effect_that_another_makes_up_for_is_not_plainly_needed():
    """The third leans towards both: with two parameters free it does most of what either does."""
    of = problem(4.0, 0.0)
    values = {"amount": 3.0, "more": 3.0}
    leaning = HypothesisTerm("leaning", EFFECTS["leaning"], values, dict.fromkeys(values, 1.0))
    gradient = HypothesisTerm("gradient", EFFECTS["gradient"], {"amount": 2.0}, {"amount": 1.0})
    begun = fit(of, (leaning, gradient))
    assert begun is not None
    everything = is_plainly_needed(of, begun, "gradient", COMPLEXITY_PENALTY)
    alone = is_plainly_needed(of, fitted(of, gradient=3.0), "gradient", COMPLEXITY_PENALTY)
    assert alone
    assert not (everything and is_plainly_needed(of, begun, "leaning", COMPLEXITY_PENALTY))


def test_an_effect_that_closes_nothing_goes_and_one_that_closes_stays():
    of = problem(4.0, 0.0)
    assert hardly_needed(of, fitted(of, gradient=3.0, ripple=1.0)) == ["ripple"]
    assert hardly_needed(of, fitted(of, gradient=3.0)) == []
    assert hardly_needed(of, fitted(of)) == []


def test_effects_that_undo_each_other_in_part_stay_together():
    """One of them leaves more than there was, so that its fair share is negative; without it much is left."""
    effects = {"gradient": EFFECTS["gradient"], "shadow": Shadow}
    of = Problem([Field(9.0 * GRADIENT + 4.0 * Shadow.patterns[0])])  # type: ignore[list-item]
    terms = [HypothesisTerm(name, cls, {"amount": 5.0}, {"amount": 1.0}) for name, cls in effects.items()]
    begun = fit(of, tuple(terms))
    assert begun is not None
    both = finished(of, begun)
    assert hardly_needed(of, both) == ["shadow"]
    assert opens_again(of, both, fitted(of, gradient=5.0))
    assert set(ForwardSelection(of, effects).run().best.names) == set(effects)


def test_what_an_effect_must_gain_is_held_against_the_captures_it_touches():
    explained, unexplained = (Field(amount * EFFECTS["gradient"].patterns[0]) for amount in (0.0, 40.0))
    of = Problem([explained, unexplained])  # type: ignore[list-item]
    null = fit(of, ())
    assert null is not None
    quiet, wild = slice(PLACES), slice(PLACES, 2 * PLACES)
    assert least_gain(of, null, [quiet]) == COMPLEXITY_PENALTY
    assert least_gain(of, null, [wild]) > 10 * COMPLEXITY_PENALTY
    assert least_gain(of, null) == pytest.approx(least_gain(of, null, [wild]), rel=0.1)
    rest = -null.score - 0.5 * of.weight * 2 * PLACES  # squares of the noise floor are 1 each
    assert least_gain(of, null) == pytest.approx(LEAST_OF_REST * rest)
