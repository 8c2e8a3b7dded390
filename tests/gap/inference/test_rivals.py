"""Whether one effect predicts better than another, and how sure that is."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tacos_gap.attribution.fits import CLOSE
from tacos_gap.attribution.selection_rule import RIVAL_SHARE, least_of_a_rival
from tacos_gap.hypotheses.parameters import HypothesisTerm
from tacos_gap.inference.fit import fit
from tacos_gap.inference.problem import Problem
from tacos_gap.inference.rivals import discrepancy, gain_beyond, slot_probabilities, standard_error
from tests.gap.inference.test_fit import Bump, Curve, X, problem, start


def test_scores_that_are_known_exactly_give_their_likelihood_ratio():
    found = slot_probabilities({"a": -3.0, "b": -4.0}, {})
    assert found["a"] / found["b"] == pytest.approx(math.e)


@given(st.floats(0.1, 60), st.floats(0, 40))
def test_an_uncertain_difference_never_makes_a_rival_less_likely(behind, error):
    sure, unsure = (slot_probabilities({"a": 0.0, "b": -behind}, {"b": e}) for e in (0.0, error))
    assert sure["b"] <= unsure["b"] + 1e-12 <= 0.5 + 1e-9
    assert sum(unsure.values()) == pytest.approx(1.0)


@pytest.mark.parametrize("error", [3.0, 30.0, 300.0])
def test_within_two_standard_errors_a_rival_stays_possible_and_far_beyond_it_does_not(error):
    assert slot_probabilities({"a": 0.0, "b": -1.2 * error}, {"b": error})["b"] > 0.08
    assert slot_probabilities({"a": 0.0, "b": -6 * error}, {"b": error})["b"] < 0.01


def test_the_standard_error_is_what_the_score_difference_spreads_over_repeated_noise():
    """Two guesses of one bump, of which neither is fitted: noise alone moves their difference."""
    differences, errors = [], []
    for seed in range(60):
        of = Problem([Curve(6.0, 0.0, 100 * seed + k) for k in range(4)])
        fits = [fit(of, (HypothesisTerm("bump", Bump, {"height": h, "bend": 0.0}, {}),)) for h in (5.0, 7.5)]
        one, other = (each for each in fits if each is not None)
        differences.append((one.score - other.score) / of.weight)
        errors.append(standard_error(of, one, other) / math.sqrt(of.weight))
    assert np.median(errors) == pytest.approx(np.std(differences), rel=0.35)


def test_what_is_negligible_makes_no_rival_unlikely_however_little_noise_there_is():
    """Two bumps that differ by a tenth of the margin in every number, and noise that is a hundredth of it."""
    errors = []
    for noise in (1.0, 0.01):
        of = problem(6.0, 0.0)
        for evidence in of.evidence:
            evidence.null_replicates = noise * evidence.null_replicates  # type: ignore[misc]
        of = Problem(of.evidence)
        fits = [fit(of, (HypothesisTerm("bump", Bump, {"height": h, "bend": 0.0}, {}),)) for h in (6.0, 6.5)]
        one, other = (each for each in fits if each is not None)
        errors.append(standard_error(of, one, other) / math.sqrt(of.weight))
    coherent = 4 * (0.5 * np.exp(-4 * X**2)).sum() ** 2  # each of four blocks off by a whole margin
    assert errors[1] ** 2 - errors[0] ** 2 == pytest.approx(coherent, rel=0.1)


def test_what_a_formula_may_miss_of_its_own_change_is_no_further_effect():
    """A large bump with a formula that misses a little of it: what would mend that is not believed."""
    of = problem(60.0, 0.6)
    rough = fit(of, (HypothesisTerm("bump", Bump, {"height": 60.0, "bend": 0.0}, {"height": 1.0}),))
    exact = fit(of, start(60.0, 0.6))
    assert rough is not None
    assert exact is not None
    nothing = np.zeros(4)
    assert gain_beyond(of, rough, exact, nothing) == pytest.approx(exact.score - rough.score)
    assert gain_beyond(of, rough, exact, nothing) > 0
    allowed = discrepancy(of, rough, share=0.05)
    assert gain_beyond(of, rough, exact, allowed) < 0.1 * (exact.score - rough.score)


# which are fitted -----------------------------------------------------------------------------------------


@given(st.floats(0, 1e5))
def test_no_effect_is_left_out_that_promises_to_come_close(gained):
    least = least_of_a_rival(gained)
    assert 0 <= least <= RIVAL_SHARE * gained
    assert least == 0 or gained - least >= CLOSE - 1e-9


def test_a_rival_of_a_strong_effect_may_promise_a_tenth_of_what_it_gains():
    """As an error of pose did, of 811 nat of another focal length's."""
    assert 20 < least_of_a_rival(811.0) < 84
