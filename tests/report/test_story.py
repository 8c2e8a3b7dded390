"""Sentences: what is claimed must follow from the numbers."""

from __future__ import annotations

from typing import Any

import pytest

from tacos_framework.fitness import standard_errors
from tacos_report import story
from tacos_report.comparison import CameraDifference, difference
from tacos_report.sections.cameras import score_table
from tacos_report.study_data import CameraResult, Generation, StudyData, Tried


def camera(name: str, fitness: float | None, *episodes: float, **scores: float) -> CameraResult:
    """A camera of that fitness; `episodes` are its fitness in each test scene."""
    what = {"pitch_deg": -22.0, "focal_length_mm": 2.9, "sensor": {"name": "IMX178"}}
    each = tuple({"fitness": value} for value in episodes)
    return CameraResult(name, f"{name} title", what, {}, scores, {}, standard_errors(each), each, fitness)


def study(*cameras: CameraResult, **result: Any) -> StudyData:
    return StudyData(result=result, cameras=cameras, generations=())


def test_a_clear_win_is_told_with_its_size_and_certainty() -> None:
    data = study(
        camera("designed", 1.2, 0.8, 1.21, 1.59),
        camera("a", 1.0, 0.6, 1.0, 1.4),
        camera("b", 0.7, 0.6, 0.7, 0.8),
    )
    assert story.headline(data) == (
        "The best camera found: the IMX178 sensor behind a 2.9\u202fmm lens, pitched 22° down. "
        "On unseen scenes it is 20\u202f% fitter than the a title, the best of 2 off-the-shelf cameras."
    )
    assert story.verdict(data) == (
        "Fitness on unseen scenes: 1.2 ± 0.2 against 1.0 ± 0.2, a difference of +0.20 ± 0.02 "
        "(95 % interval over the test scenes)."
    )


def test_a_difference_that_wavers_from_scene_to_scene_is_no_win() -> None:
    data = study(camera("designed", 1.08, 1.0, 1.1, 1.14), camera("a", 1.0, 1.1, 1.0, 0.9))
    assert "is not clearly different from the a title" in story.headline(data)
    assert "which may be chance: more test scenes would be needed" in story.verdict(data)


def test_a_loss_is_called_a_loss() -> None:
    data = study(camera("designed", 0.8, 0.7, 0.9), camera("a", 1.0, 0.9, 1.1))
    assert story.headline(data).endswith(
        "On unseen scenes it is 20\u202f% less fit than the a title, and should not replace it."
    )


def test_without_spread_the_uncertainty_is_called_unknown() -> None:
    assert "Its uncertainty is not known" in story.verdict(study(camera("designed", 1.2), camera("a", 1.0)))


def test_the_interval_is_students_of_the_paired_differences() -> None:
    from scipy.stats import ttest_rel

    ours, theirs = (1.3, 1.1, 1.6, 0.9), (1.1, 1.05, 1.2, 0.8)
    change = difference(camera("designed", 1.225, *ours), camera("a", 1.0375, *theirs), "fitness")
    interval = ttest_rel(ours, theirs).confidence_interval(0.95)
    assert change is not None
    assert change.error == pytest.approx((interval.high - interval.low) / 2)


def test_no_percentage_of_a_fitness_below_zero() -> None:
    data = study(camera("designed", 0.5), camera("a", -1.0))
    assert "%" not in story.headline(data)
    assert "a difference of +1.5" in story.verdict(data)


def test_scores_are_told_one_by_one() -> None:
    data = study(
        camera("designed", 1.2, **{"features.inliers": 150.0, "obstacle.seen_ratio": 0.9}),
        camera("a", 1.0, **{"features.inliers": 100.0, "obstacle.seen_ratio": 1.0}),
    )
    assert story.per_score(data) == (
        "Against the a title, score by score: features: inliers +50\u202f%; obstacle: seen ratio −10\u202f%."
    )


def test_only_scores_that_the_fitness_takes_are_told() -> None:
    data = study(
        camera("designed", 1.2, **{"features.inliers": 150.0, "detect.ap50_sofa": 0.9}),
        camera("a", 1.0, **{"features.inliers": 100.0, "detect.ap50_sofa": 0.1}),
        fitness=[{"score": "features.inliers", "weight": 1}],
    )
    assert "inliers +50" in story.per_score(data)
    assert "sofa" not in story.per_score(data)


def test_a_score_of_negative_weight_is_better_when_lower() -> None:
    ours, theirs = camera("designed", 1.0, **{"depth.error": 0.1}), camera("a", 1.0, **{"depth.error": 0.2})
    change = difference(ours, theirs, "depth.error", higher_is_better=False)
    assert change is not None
    assert change.outcome == "better"


def test_errors_that_the_fitness_leaves_out_are_better_when_lower() -> None:
    ours = camera("designed", 1.0, **{"depth.error": 0.1, "depth.share": 0.1})
    theirs = camera("a", 0.9, **{"depth.error": 0.2, "depth.share": 0.2})
    data = study(ours, theirs, lower_is_better=["depth.error"])
    rows = {label.text: cells for label, *cells in score_table(data).rows}
    *error, of_error = rows["depth: error"]
    *share, of_share = rows["depth: share"]
    assert (of_error.detail, of_share.detail) == ("better", "worse")
    assert [cell.best for cell in error] == [True, False]
    assert [cell.best for cell in share] == [False, True]
    weighed = study(
        ours, theirs, fitness=[{"score": "depth.error", "weight": 1}], lower_is_better=["depth.error"]
    )
    assert story.score_changes(weighed, theirs)["depth.error"].outcome == "worse"  # the weight decides


@pytest.mark.parametrize(
    ("designed", "error", "outcome"),
    [(1.3, 0.1, "better"), (1.05, 0.1, "undecided"), (0.7, 0.1, "worse"), (1.01, None, "better"),
     (1.0, None, "undecided")],
)  # fmt: skip
def test_the_outcome_needs_an_interval_without_zero(
    designed: float, error: float | None, outcome: str
) -> None:
    assert CameraDifference(designed, 1.0, error).outcome == outcome


@pytest.mark.parametrize(
    ("what", "expected"),
    [
        (
            {"baseline_m": 1.84, "hfov_deg": 50.0},
            "a baseline of 1.84\u202fm, a horizontal field of view of 50°",
        ),
        ({"pitch_deg": 0.0, "focal_length_mm": 4.0}, "a 4\u202fmm lens, mounted level"),
        ({"pitch_deg": 7.25}, "pitched 7.2° up"),
        (
            {"effects.defocus.focus_m": 1.5, "scenario.f_number": 4.0, "sensor_binning": 1},
            "a distance of focus of 1.5\u202fm, an f-number of 4, no binning",
        ),
        ({}, "one without design variables"),
    ],
)
def test_designs_in_words(what: dict[str, Any], expected: str) -> None:
    assert story.design_words(what) == expected


def test_failures_that_differ_in_numbers_are_one_reason() -> None:
    reasons = ["hfov_deg is 150.2, above 140", "no memory", "hfov_deg is 161, above 140", None]
    groups = story.failure_groups([Tried(0, {}, {}, None, reason) for reason in reasons])
    assert [(group.count, group.example) for group in groups] == [(2, reasons[0]), (1, "no memory")]


def test_the_search_tells_whether_it_had_settled() -> None:
    def searched(*best: float) -> StudyData:
        rounds = tuple(Generation(i, 10, (Tried(i, {}, {}, value),)) for i, value in enumerate(best))
        return StudyData(result={}, cameras=(), generations=rounds)

    assert story.search_words(searched(1.0, 3.0, 2.0, 2.5)).endswith(
        "2 later generations found nothing higher."
    )
    assert story.search_words(searched(1.0, 2.0)).endswith("the last: a longer search may find a better one.")
    assert story.search_words(searched()) == "No generation was finished."
