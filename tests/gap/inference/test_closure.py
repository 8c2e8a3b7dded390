"""Shares of effects in a closed gap: games worked by hand, and what makes a share fair."""

from __future__ import annotations

from itertools import combinations, permutations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tacos_gap.inference.closure import closure, closures_of, shapley
from tacos_gap.inference.fit import Fitted, finished, fit
from tacos_gap.inference.problem import Problem
from tests.gap.inference.test_fit import problem, start

NAMES = ("blur", "noise", "tone", "tint")


def game(count: int, values: list[float]) -> dict[tuple[str, ...], float]:
    """What each subset of the first `count` effects achieves; nothing achieves 0."""
    names = NAMES[:count]
    subsets = [s for size in range(1, count + 1) for s in combinations(names, size)]
    return {(): 0.0, **dict(zip(subsets, values, strict=False))}


games = st.integers(1, 4).flatmap(
    lambda count: st.lists(
        st.floats(-1, 1, allow_subnormal=False), min_size=2**count - 1, max_size=2**count - 1
    ).map(lambda values: (NAMES[:count], game(count, values)))
)


def test_three_effects_that_help_one_another_share_as_worked_by_hand():
    """A third of what each adds alone, a sixth after either of the others, a third after both:

    blur:  (0.12 + 0.54) / 3 + (0.30 + 0.24) / 6 = 0.31
    noise: (0.18 + 0.60) / 3 + (0.36 + 0.30) / 6 = 0.37
    tone:  (0.06 + 0.42) / 3 + (0.18 + 0.18) / 6 = 0.22
    """
    worth = {
        (): 0.0,
        ("blur",): 0.12,
        ("noise",): 0.18,
        ("tone",): 0.06,
        ("blur", "noise"): 0.48,
        ("blur", "tone"): 0.30,
        ("noise", "tone"): 0.36,
        ("blur", "noise", "tone"): 0.90,
    }
    shares = shapley(("blur", "noise", "tone"), worth.__getitem__)
    assert shares == pytest.approx({"blur": 0.31, "noise": 0.37, "tone": 0.22}, abs=1e-6)


def test_an_effect_that_is_needed_by_both_others_gets_the_most():
    """Either glove of the right hand with the one of the left: 2/3, 1/6 and 1/6 (Shapley 1953)."""

    def pair(subset: tuple[str, ...]) -> float:
        return float("left" in subset and len(subset) > 1)

    shares = shapley(("left", "right", "other right"), pair)
    assert shares == pytest.approx({"left": 2 / 3, "right": 1 / 6, "other right": 1 / 6}, abs=1e-6)


@given(games)
def test_a_share_is_what_an_effect_adds_on_average_over_all_orders(named):
    names, worth = named
    added = dict.fromkeys(names, 0.0)
    orders = list(permutations(names))
    for order in orders:
        for place, name in enumerate(order):
            before = tuple(n for n in names if n in order[:place])
            after = tuple(n for n in names if n in order[: place + 1])
            added[name] += (worth[after] - worth[before]) / len(orders)
    assert shapley(names, worth.__getitem__) == pytest.approx(added, abs=2e-6)


@given(games)
def test_shares_add_up_to_what_all_achieve_together(named):
    names, worth = named
    assert sum(shapley(names, worth.__getitem__).values()) == pytest.approx(worth[names], abs=1e-5)


@given(st.lists(st.floats(-1, 1), min_size=6, max_size=6))
def test_effects_that_do_the_same_share_alike_and_one_that_does_nothing_gets_nothing(values):
    """Of four effects the first two count only by their number, and the last not at all."""

    def worth(subset: tuple[str, ...]) -> float:
        alike = len({"blur", "noise"} & set(subset))
        number = alike + 3 * ("tone" in subset)
        return values[number] if number else 0.0

    shares = shapley(NAMES, worth)
    assert shares["blur"] == shares["noise"]
    assert shares["tint"] == 0.0


def test_more_effects_than_can_be_enumerated_are_refused():
    with pytest.raises(ValueError, match="7 effects take too many subsets; at most 6"):
        shapley(tuple("abcdefg"), lambda _: 0.0)


def test_two_thirds_of_the_squares_count_as_such_however_large_they_are():
    assert closure(197.0, 114.0) == pytest.approx(2 / 3, abs=0.01)


def explained(height: float, bend: float = 0.0, count: int = 4) -> tuple[Problem, Fitted]:
    of = problem(height, bend, count)
    begun = fit(of, start())
    assert begun is not None
    return of, finished(of, begun)


def test_one_closure_for_all_who_ask_and_an_interval_that_holds_it():
    of, found = explained(9.0, 1.0)
    closures = closures_of(of, found, np.random.default_rng(0))
    assert closures.together.value == pytest.approx(closure(of.gap(of.null), of.gap(found.held_out)))
    assert closures.fair["bump"].value == pytest.approx(closures.together.value, abs=1e-6)
    low, high = closures.together.interval
    assert low <= closures.together.value <= high
    assert high - low < 0.3
