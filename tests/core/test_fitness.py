"""Fitness: the paper's weighted sum, constraints in sentences, and means over the episodes that count."""

from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tacos_framework.errors import CandidateFailed
from tacos_framework.fitness import (
    Fitness,
    FitnessTerm,
    mean_scores,
    standard_errors,
    weighted_mean,
)

PAPER = Fitness(
    (
        FitnessTerm("features.inliers", 0.0025),
        FitnessTerm("features.inlier_ratio", 0.5),
        FitnessTerm("detect.ap50", 1.0),
        FitnessTerm("obstacle.seen_ratio", 1.0),
    )
)
QUANTIZED_DAY = {
    "features.inliers": 230.0,
    "features.inlier_ratio": 0.13,
    "detect.ap50": 0.46,
    "obstacle.seen_ratio": 1.0,
}


def test_the_paper_s_sum_for_a_row_of_its_table() -> None:
    assert PAPER.value(QUANTIZED_DAY) == pytest.approx(0.575 + 0.065 + 0.46 + 1.0)
    assert PAPER.contributions(QUANTIZED_DAY) == pytest.approx(
        {
            "features.inliers": 0.575,
            "features.inlier_ratio": 0.065,
            "detect.ap50": 0.46,
            "obstacle.seen_ratio": 1.0,
        }
    )


@given(st.lists(st.tuples(st.floats(-1e6, 1e6), st.floats(-1e6, 1e6)), min_size=1, max_size=6))
def test_the_value_is_the_sum_of_its_terms(pairs: list[tuple[float, float]]) -> None:
    fitness = Fitness(tuple(FitnessTerm(f"t.s{i}", weight) for i, (weight, _) in enumerate(pairs)))
    scores = {f"t.s{i}": score for i, (_, score) in enumerate(pairs)}
    assert fitness.value(scores) == math.fsum(fitness.contributions(scores).values())
    assert fitness.value(scores) == pytest.approx(sum(w * s for w, s in pairs), abs=1e-3)


def test_scores_the_fitness_does_not_name_are_left_alone() -> None:
    assert Fitness((FitnessTerm("a.b", 2.0),)).value({"a.b": 3.0, "a.other": math.nan}) == 6.0


def test_a_missing_score_fails_the_candidate_and_is_named() -> None:
    scores = {name: value for name, value in QUANTIZED_DAY.items() if not name.startswith("obstacle")}
    with pytest.raises(
        CandidateFailed, match=r"value for obstacle.seen_ratio, .* reported: detect.ap50, feat"
    ):
        PAPER.value(scores)
    with pytest.raises(
        CandidateFailed, match=r"for features.inliers, features.inlier_ratio, .* reported: none$"
    ):
        PAPER.contributions({})


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_scores_that_are_no_numbers_are_a_defect_of_the_task(value: float) -> None:
    with pytest.raises(ValueError, match=f"score detect.ap50 is {value}"):
        PAPER.value({**QUANTIZED_DAY, "detect.ap50": value})
    with pytest.raises(ValueError, match=f"score a.b is {value}"):
        mean_scores([{"a.b": 1.0}, {"a.b": value}])


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: FitnessTerm("a.b", math.nan), "the weight of a.b must be a finite number, not nan"),
        (lambda: Fitness(()), "a fitness needs at least one term"),
        (
            lambda: Fitness((FitnessTerm("a.b", 1), FitnessTerm("a.b", 2))),
            "the fitness names a.b more than once",
        ),
        (lambda: Fitness(tuple(FitnessTerm(n, 1) for n in "baba")), "the fitness names a, b more than once"),
    ],
)
def test_what_makes_no_sense_is_refused(build: Any, message: str) -> None:
    with pytest.raises(ValueError, match=f"^{message}$"):
        build()


def test_means_are_over_the_episodes_that_report_a_score() -> None:
    episodes = [{"a.x": 1.0, "b.y": 5.0}, {"a.x": 3.0}, {"a.x": 5.0, "b.y": 7.0}]
    assert mean_scores(episodes) == {"a.x": 3.0, "b.y": 6.0}
    assert mean_scores([{}, {}]) == {}
    assert mean_scores(iter([])) == {}


@given(st.lists(st.floats(-1e9, 1e9), min_size=1, max_size=20), st.randoms())
def test_the_mean_does_not_depend_on_the_order_of_episodes(values: list[float], random: Any) -> None:
    shuffled = random.sample(values, len(values))
    assert mean_scores({"s": v} for v in values) == mean_scores({"s": v} for v in shuffled)


def test_standard_errors_are_of_the_scores_that_every_episode_reports() -> None:
    """1, 3 and 5 scatter by 2 about their mean."""
    episodes = [{"a.x": 1.0, "b.y": 5.0}, {"a.x": 3.0, "c.z": 1.0}, {"a.x": 5.0, "c.z": 2.0}]
    assert standard_errors(episodes) == {"a.x": pytest.approx(2 / math.sqrt(3))}
    assert standard_errors(episodes[1:]) == pytest.approx({"a.x": 1.0, "c.z": 0.5})
    assert standard_errors(episodes[:1]) == {}
    assert standard_errors([]) == {}


DAY_AND_NIGHT = (("day", 1.0), ("night", 3.0))


def test_scenarios_count_by_their_weights_or_the_worst_alone() -> None:
    scores = {"day": {"a.x": 1.0}, "night": {"a.x": 2.0}}
    mean = Fitness((FitnessTerm("a.x", 2.0),), DAY_AND_NIGHT)
    assert mean.weights(scores) == mean.mean_weights == {"day": 0.25, "night": 0.75}
    worst = Fitness((FitnessTerm("a.x", 2.0),), DAY_AND_NIGHT, "worst")
    assert worst.weights(scores) == {"day": 1.0, "night": 0.0}
    errors = Fitness((FitnessTerm("a.x", -1.0),), DAY_AND_NIGHT, "worst")
    assert errors.weights(scores) == {"day": 0.0, "night": 1.0}


def test_a_scenario_without_a_score_that_counts_fails_the_candidate_by_its_name() -> None:
    fitness = Fitness((FitnessTerm("a.x", 2.0),), DAY_AND_NIGHT)
    with pytest.raises(CandidateFailed, match=r"^in scenario 'night': .*a\.x"):
        fitness.weights({"day": {"a.x": 1.0}, "night": {"b.y": 1.0}})


def test_a_mean_over_scenarios_is_over_those_that_report_a_score_and_count() -> None:
    by_scenario = {"day": {"a.x": 1.0, "b.y": 5.0}, "night": {"a.x": 5.0}, "fog": {"a.x": 100.0, "c.z": 1.0}}
    weights = {"day": 1.0, "night": 3.0, "fog": 0.0}
    assert weighted_mean(by_scenario, weights) == {"a.x": 4.0, "b.y": 5.0}
    assert weighted_mean(by_scenario, {"day": 1.0}) == {"a.x": 1.0, "b.y": 5.0}


@given(
    st.lists(st.tuples(st.floats(-5, 5), st.floats(0, 5)), min_size=1, max_size=5),
    st.integers(0, 4),
)
def test_the_margin_grows_with_that_of_each_score_and_knows_no_zero(terms, which):
    fitness = Fitness(tuple(FitnessTerm(f"t.s{i}", *term) for i, term in enumerate(terms)))
    alone = [abs(weight * margin) for weight, margin in terms]
    assert max(alone) <= fitness.margin * (1 + 1e-9) <= sum(alone) * (1 + 1e-8) + 1e-12
    assert set(fitness.margins) == {f"t.s{i}" for i, (_, margin) in enumerate(terms) if margin}


@pytest.mark.parametrize("margin", [-1.0, math.nan, math.inf])
def test_a_margin_is_a_number_of_0_or_more(margin):
    with pytest.raises(ValueError, match=r"the margin of a\.b must be 0 or more"):
        FitnessTerm("a.b", 1.0, margin)
