"""Orange is the designed camera in every drawing, whatever else ranks first or was lucky."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest

from tacos_report.analysis import FrontPoint, Objective, RankedPart
from tacos_report.figures.catalog_choices import catalog_choices
from tacos_report.figures.explored import Panel, explored
from tacos_report.figures.parts_ranked import parts_ranked
from tacos_report.figures.search_curve import search_curve
from tacos_report.figures.trade_offs import trade_offs
from tacos_report.page import Table
from tacos_report.sections import ranking
from tacos_report.story import chosen_words
from tacos_report.study_data import CameraResult, Generation, StudyData, Tried, parts_of

ORANGE = "var(--camera-0)"
NAMES = ("lucky", "second", "third", "fourth", "chosen", "last")
CHOSEN = {"sensor": {"name": "chosen"}, "focal_length_mm": 3.0}


def tried(name: str, fitness: float) -> Tried:
    return Tried(0, {"sensor": {"name": name}, "focal_length_mm": 3.0}, {}, fitness)


SCORED = tuple(tried(name, 2.0 - 0.1 * place) for place, name in enumerate(NAMES))
RANKED = tuple(
    RankedPart(each.camera["sensor"]["name"], each.camera, each.fitness or 0.0, (0.5, 2.5), {}, True, 4, ())
    for each in SCORED
)


def study(camera: CameraResult | None = None) -> StudyData:
    data = StudyData(
        {},
        (camera or CameraResult("designed", "Designed camera", CHOSEN, {}),),
        (Generation(0, 60, SCORED),),
    )
    return replace(data, analysis=replace(data.analysis, ranking=RANKED))


def orange_words(svg: str) -> list[str]:
    """The words of a drawing in the colour of the design."""
    return re.findall(r"<text[^>]*" + re.escape(ORANGE) + r"[^>]*>([^<]*)<", svg)


@pytest.mark.parametrize("narrow", [False, True])
def test_the_ranking_marks_the_design_and_not_its_first(narrow: bool) -> None:
    assert orange_words(parts_ranked(RANKED, {}, ["chosen"], narrow)) == ["chosen"]
    assert ORANGE not in parts_ranked(RANKED, {}, [], narrow)


def test_the_ranking_of_a_phone_is_short_and_has_the_design() -> None:
    _, table, _ = ranking.blocks(study())
    assert isinstance(table, Table)
    assert [row[0] for row in table.rows] == list("123456")
    assert (table.first, table.kept) == (3, (4,))


def test_a_ranking_of_cameras_marks_the_designed_one() -> None:
    camera = CameraResult("designed", "Designed camera", {"focal_length_mm": 3.0}, {})
    by_name = [replace(RANKED[0], part=name, camera={"focal_length_mm": 3.0}) for name in ("designed", "b")]
    assert [study(camera).has_parts_of_design(part) for part in by_name] == [True, False]


def test_a_combination_of_parts_is_the_design_as_a_whole() -> None:
    both = {"sensor": {"name": "chosen"}, "lens": {"name": "wide"}}
    camera = CameraResult("designed", "Designed camera", both, {})
    other = replace(RANKED[0], camera={**both, "lens": {"name": "long"}})
    assert [study(camera).has_parts_of_design(replace(other, camera=c)) for c in (both, other.camera)] == [
        True,
        False,
    ]


def test_the_star_of_the_search_is_the_design_and_not_the_luckiest() -> None:
    curve = search_curve(study().generations, study().shows_design)
    assert orange_words(curve) == ["1.6"]
    assert "a higher dot may owe its place to luck" in chosen_words(study())


def test_a_design_that_was_recommended_has_no_star_and_the_page_says_why() -> None:
    unseen = study(CameraResult("designed", "Designed camera", {**CHOSEN, "focal_length_mm": 3.1}, {}))
    assert ORANGE not in search_curve(unseen.generations, unseen.shows_design)
    assert "none of them: the optimizer predicted" in chosen_words(unseen)


def test_the_space_names_the_design_and_not_the_luckiest() -> None:
    panel = Panel("focal_length_mm", "mm", (1.0, 2.0, 3.0, 4.0, 5.0, 6.0), 5.0)
    assert "Focal length: 5\u202fmm" in explored([panel], SCORED)
    assert ORANGE not in explored([replace(panel, designed=None)], SCORED)


def test_choices_of_a_catalog_show_the_design_wherever_it_ranks() -> None:
    many = tuple(tried(f"part {i}", 3.0 - 0.01 * i) for i in range(12))
    drawn = catalog_choices("sensor", (*many, *SCORED), parts_of(CHOSEN)["sensor"])
    assert [said.split(" ")[0] for said in orange_words(drawn)] == ["chosen", "1.6"]
    assert "11 of 18 tried" in drawn


def test_a_front_marks_the_design_where_it_is_one_of_its_points() -> None:
    points = [FrontPoint("", each.camera, {"size": 1.0}, each.fitness or 0.0, None, True) for each in SCORED]
    objective = [Objective("size", "", "min")]
    assert ORANGE in trade_offs(objective, points, CHOSEN)
    assert ORANGE not in trade_offs(objective, points, {**CHOSEN, "focal_length_mm": 9.0})
