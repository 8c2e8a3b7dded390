"""What the study decided, in words an engineer can act on."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from tacos_report import story
from tacos_report.analysis import read_analysis
from tacos_report.comparison import CameraDifference
from tacos_report.sections import decision, purchase
from tacos_report.study_data import CameraResult, Generation, StudyData, Tried
from tests.report.analysed_results import decided

PRODUCTS = {"oak": "Luxonis OAK-D", "flea3": "FLIR Flea3"}
CAMERAS = {name: {} for name in ("designed", *PRODUCTS)}


def study(verdict: str = "better", **changes: Any) -> StudyData:
    """A tested study with that verdict, without any of its pictures."""
    result = {**decided({"cameras": CAMERAS}, verdict), **changes}
    designed = CameraResult("designed", "Designed camera", {"focal_length_mm": 3.0}, {}, fitness=1.5)
    products = [CameraResult(name, title, {}, {}, fitness=1.4) for name, title in PRODUCTS.items()]
    return StudyData(result, (designed, *products), (), analysis=read_analysis(result))


@pytest.mark.parametrize(
    ("verdict", "said"),
    [
        ("better", "better than the Luxonis OAK-D, the best of 2 off-the-shelf cameras, at 95\u202f% "),
        ("worse", "worse than the Luxonis OAK-D, the best of 2 off-the-shelf cameras, at 95\u202f% "),
        ("equivalent", "within a margin of 0.012, at 95\u202f% confidence: either will do."),
        ("undecided", "is undecided after 12 test scenes."),
    ],
)  # fmt: skip
def test_the_headline_tells_the_verdict_and_how_sure_it_is(verdict: str, said: str) -> None:
    headline = story.headline(study(verdict))
    assert headline.startswith("The best camera found: a 3\u202fmm lens. ")
    assert said in headline


@pytest.mark.parametrize("verdict", ["better", "worse", "equivalent", "undecided"])
def test_the_lead_has_difference_interval_scenes_and_margin(verdict: str) -> None:
    lead = story.verdict(study(verdict))
    for part in (
        "95\u202f% confidence between",
        "12 test scenes",
        "Differences below 0.012, from 2 in features: inliers, are negligible",
    ):
        assert part in lead
    assert ("test.most_episodes" in lead) == (verdict == "undecided")


def test_too_few_scenes_for_an_interval_have_none() -> None:
    result = decided({"cameras": CAMERAS}, "undecided")
    data = study("undecided", decision={**result["decision"], "interval": None, "episodes": 2})
    assert "after 2 test scenes, which are too few for an interval." in story.verdict(data)
    assert "looks" not in story.verdict(data)


def test_a_part_that_says_what_it_is_is_not_told_twice() -> None:
    lens = {"name": "OpenMV IR Lens 3.6 mm"}
    assert story.design_words({"lens": lens}) == "the OpenMV IR Lens 3.6 mm"
    assert story.design_words({"lens": {"name": "DSL219"}}) == "the DSL219 lens"


def test_a_degenerate_study_names_no_camera_and_says_what_to_do() -> None:
    data = study(degenerate="All 40 cameras score zero: give more light.")
    assert story.headline(data) == "This study names no camera: its scores do not separate them."
    assert story.verdict(data) == "All 40 cameras score zero: give more light."


def test_products_that_break_a_constraint_are_shown_with_the_reason() -> None:
    (*_, table) = decision.blocks(study())
    assert table.kind == "table"
    assert ("fisheye 190", "", "hfov_deg is 152, above its maximum of 140", "") in table.rows


def test_a_product_without_results_has_its_title() -> None:
    why = {"against": "oak_d", "title": "Luxonis OAK-D", "verdict": "not admissible", "why": "It is rolling."}
    (*_, table) = decision.blocks(study(comparisons=[why]))
    assert table.rows[0][:3] == ("Luxonis OAK-D", "", "It is rolling.")


def test_where_no_product_is_admissible_the_reason_is_told() -> None:
    why = {"against": "oak", "verdict": "not admissible", "why": "megapixels is 24, above its maximum of 20."}
    result = {"comparisons": [why]}
    designed = CameraResult("designed", "Designed camera", {}, {}, fitness=1.5)
    text = story.verdict(StudyData(result, (designed,), (), analysis=read_analysis(result)))
    assert text.endswith("can be compared with it. oak: megapixels is 24, above its maximum of 20.")


def test_without_a_test_section_nothing_has_ended_early() -> None:
    designed = CameraResult("designed", "Designed camera", {}, {})
    assert "has no section test" in story.verdict(StudyData({}, (designed,), (), asks_for_test=False))
    assert "ended before its test" in story.verdict(StudyData({}, (designed,), ()))


def test_that_nothing_could_be_scored_comes_with_the_reason() -> None:
    data = StudyData({"failed": {"designed": "no keypoint."}}, (), ())
    assert story.verdict(data) == "The reason: no keypoint."
    assert story.verdict(StudyData({}, (), ())) == "The log says why."
    tried = Generation(0, 0, (Tried(0, {}, {}, None, "no memory"),))
    assert story.verdict(StudyData({}, (), (tried,))) == "Most often the reason was: no memory."


@pytest.mark.parametrize(
    ("ours", "theirs", "told"), [(7.942, 0.1, False), (1.2, 1.0, True), (0.2, 0.0, False)]
)
def test_changes_against_next_to_nothing_are_no_percentages(ours: float, theirs: float, told: bool) -> None:
    assert (CameraDifference(ours, theirs, None).share is not None) == told


def test_a_change_within_the_noise_of_the_other_value_is_no_percentage() -> None:
    assert CameraDifference(0.3, 0.2, 0.25).share is None


@pytest.mark.parametrize("verdict", ["better", "worse", "equivalent", "undecided"])
def test_what_to_buy_is_the_product_where_that_is_better(verdict: str) -> None:
    found = study(verdict)
    part = {"name": "IMX273", "width_px": 1456}
    designed = replace(found.designed, camera={**found.designed.camera, "sensor": part})
    first, *_ = purchase.blocks(replace(found, cameras=(designed, *found.cameras[1:])))
    assert (first.kind == "paragraph") == (verdict == "worse")
    assert verdict != "worse" or first.text.startswith("The Luxonis OAK-D, which was better in the test.")
