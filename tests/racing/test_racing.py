"""Who is dropped from a race, when, and what stands for its fitness."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tacos_framework.fitness import Fitness, FitnessTerm, mean_scores
from tacos_framework.study.racing import Race, contributions

FITNESS = Fitness((FitnessTerm("a", 1.0),))
TWO_TERMS = Fitness((FitnessTerm("a", 0.5), FitnessTerm("b", -2.0)))

numbers = st.floats(-100, 100)
blocks_of_two = st.lists(
    st.one_of(
        st.fixed_dictionaries({"a": numbers, "b": numbers}),
        st.fixed_dictionaries({"a": numbers}),
        st.fixed_dictionaries({"b": numbers}),
    ),
    min_size=1,
    max_size=12,
)


@given(blocks_of_two)
def test_the_mean_of_contributions_is_the_fitness_of_all_blocks(blocks):
    found = contributions(blocks, TWO_TERMS)
    if min(sum(name in scores for scores in blocks) for name in "ab") < 2:
        assert found is None
    else:
        assert found.mean() == pytest.approx(TWO_TERMS.value(mean_scores(blocks)), abs=1e-9)


@given(st.lists(numbers, min_size=2, max_size=8), st.integers(0, 8))
def test_a_score_of_some_blocks_has_the_standard_error_of_those(values, silent):
    blocks = [{"a": value} for value in values] + [{}] * silent
    found = contributions(blocks, FITNESS)
    expected = np.std(values, ddof=1) / math.sqrt(len(values))
    assert found.std(ddof=1) / math.sqrt(len(found)) == pytest.approx(expected, abs=1e-9)


def race(**scores: list[float]) -> Race:
    race = Race(FITNESS, standard_errors=2.0, min_blocks=3)
    for key, values in scores.items():
        race.saw(key, [{"a": value} for value in values])
    return race


def test_nobody_is_dropped_before_the_least_number_of_blocks():
    early = race(good=[1.0, 1.0], bad=[0.0, 0.0])
    assert early.drop() == []
    early.saw("good", [{"a": 1.0}])
    early.saw("bad", [{"a": 0.0}])
    assert early.drop() == ["bad"]


def test_what_counts_is_the_difference_block_by_block_not_the_spread_of_blocks():
    hard_and_easy = [0.0, 100.0, 50.0]
    paired = race(
        good=hard_and_easy, bad=[x - 1 - d for x, d in zip(hard_and_easy, (0.1, 0, 0.2), strict=True)]
    )
    assert paired.drop() == ["bad"]
    unpaired = race(good=hard_and_easy, bad=[49.0, -1.0, 99.0])
    assert unpaired.drop() == []


def test_a_gap_within_the_standard_errors_is_not_enough():
    differences = [0.0, 1.0, 2.0]  # mean 1, standard error 0.577
    good = [5.0, 5.0, 5.0]
    bad = [g - d for g, d in zip(good, differences, strict=True)]
    assert race(good=good, bad=bad).drop() == []
    strict = Race(FITNESS, standard_errors=1.7, min_blocks=3)
    strict.saw("good", [{"a": v} for v in good])
    strict.saw("bad", [{"a": v} for v in bad])
    assert strict.drop() == ["bad"]


def test_candidates_are_compared_on_the_blocks_all_have_seen():
    known = race(known=[1.0, 1.0, 1.0, -50.0, -50.0], bad=[0.5, 0.4, 0.5])
    assert known.drop() == ["bad"]


def test_a_candidate_whose_scores_say_too_little_stays():
    silent = Race(TWO_TERMS, standard_errors=2.0, min_blocks=3)
    silent.saw("good", [{"a": 9.0, "b": 0.0}] * 3)
    silent.saw("quiet", [{"a": 0.0}, {"a": 0.0}, {"a": 0.0, "b": 0.0}])
    assert silent.drop() == []


def test_one_that_failed_is_no_rival():
    failing = race(best=[9.0, 9.0, 9.0], bad=[0.0, 0.0, 0.0])
    failing.withdraw("best")
    assert failing.drop() == []


@given(st.lists(st.lists(st.floats(-5, 5), min_size=8, max_size=8), min_size=2, max_size=8, unique_by=tuple))
def test_a_dropped_candidate_is_told_less_than_one_that_saw_all_blocks(scores):
    race = Race(FITNESS, standard_errors=1.0, min_blocks=2)
    running = dict(enumerate(scores))
    for first in range(8):
        for key, values in running.items():
            race.saw(key, [{"a": values[first]}])
        for key in race.drop():
            del running[key]
    whole = {key: float(np.mean(values)) for key, values in running.items()}
    dropped = race.fitness_of_dropped(whole)
    assert set(dropped) == set(range(len(scores))) - set(running)
    assert all(fitness < max(whole.values()) for fitness in dropped.values())


def test_one_dropped_for_a_leader_that_fails_later_is_compared_with_the_best_that_is_left():
    race = Race(FITNESS, standard_errors=2, min_blocks=3)
    easy, hard = ({"a": 9.0}, {"a": 9.2}, {"a": 9.1}), ({"a": 1.0}, {"a": 1.0})
    race.saw("leader", [{"a": 10.0}, {"a": 10.1}, {"a": 10.2}])
    race.saw("dropped", easy)
    race.saw("left", [{"a": 9.95}, {"a": 10.2}, {"a": 10.1}])
    assert race.drop() == ["dropped"]
    race.withdraw("leader")
    race.saw("left", hard)
    left = float(np.mean([9.95, 10.2, 10.1, 1.0, 1.0]))
    told = race.fitness_of_dropped({"left": left})["dropped"]
    assert told == pytest.approx(left - np.mean([0.95, 1.0, 1.0])), "its mean over the easy blocks is 9.1"


def test_blocks_that_were_easy_do_not_lift_those_that_saw_only_them():
    easy_first = race(good=[10.0, 10.1, 10.2, 0.0, 0.0], bad=[9.0, 9.2, 9.1])
    assert easy_first.drop() == ["bad"]
    good = (10.0 + 10.1 + 10.2) / 5
    assert easy_first.fitness_of_dropped({"good": good}) == {"bad": pytest.approx(good - 1.0)}
    assert str(easy_first.dropped["bad"]).startswith("dropped after 3 blocks: 1 behind the leader")
