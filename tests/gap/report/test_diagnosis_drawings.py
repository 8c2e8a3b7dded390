"""What the drawings of a diagnosis are made of."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest

from tacos_framework.contracts.observed import FileCoding
from tacos_gap.evidence import ImageEvidence, Label
from tacos_gap.inference.problem import Problem
from tacos_gap.report.arrows import arrows, of_tiles
from tacos_gap.report.drawings import is_wide, mapped
from tacos_gap.report.frames import CROP_PX, compare, to_show
from tacos_gap.report.image_map import image_map
from tacos_gap.report.numbers import Numbers, numbers_of
from tacos_gap.report.overview import MOST, overview
from tacos_gap.report.profiles import profile
from tacos_gap.statistics.views import over, place_words, view_of
from tacos_report.figures.canvas import NARROW_IN
from tests.gap.taken import HEIGHT, WIDTH, capture, taken

BOX = [0, 0, 20, 20]
CODING = FileCoding(quality=95, subsampling="4:2:0")
CALLED: dict[str, Any] = {"before": "was", "after": "is"}


def numbers(
    statistic: str, places: list[Mapping[str, Any]], z_before: list[float], stage: str = "optics"
) -> Numbers:
    labels = [Label("a", "flat", statistic, stage, at) for at in places]
    z = np.array(z_before)
    size = float(np.sqrt(np.mean(z**2)))
    return Numbers(statistic, stage, labels, z, 0.1 * z, np.full(len(z), 0.02), np.ones(len(z)), size, 0.1)


@pytest.mark.parametrize(
    ("at", "kind"),
    [
        ({"box_px": BOX, "radius": [0, 0.2], "channel": "R"}, "image"),
        ({"box_px": BOX, "axis": "x"}, "arrows"),
        ({"radius": [0.2, 0.2], "axis": "y"}, "arrows"),
        ({"level_dn": 12.0, "channel": "mono"}, "level"),
        ({"radius": [0, 1], "frequency_cycles_px": [0.1, 0.2], "direction_deg": 0}, "frequency"),
        ({"radius": [0.3, 0.6]}, "radius"),
        ({"period_rows": 60.0}, "period"),
        ({"lag_px": [0, 1]}, "places"),
        ({}, "places"),
    ],
)
def test_what_a_statistic_is_drawn_over_follows_from_its_places(at: Mapping[str, Any], kind: str) -> None:
    assert over([at]) == kind


def test_simulated_values_are_the_real_ones_less_the_differences() -> None:
    found = numbers("level", [{"level_dn": 10.0}, {"level_dn": 20.0}], [5.0, -10.0])
    assert found.before.tolist() == pytest.approx([0.9, 1.2])
    assert found.after.tolist() == pytest.approx([0.99, 1.02])


def test_displacements_of_red_and_blue_stay_apart() -> None:
    places = [{"box_px": BOX, "axis": axis, "channels": c} for c in ("R-G", "B-G") for axis in "xy"]
    red, blue = of_tiles(numbers("colour_displacement", places, [10.0, 0.0, -10.0, 5.0]))
    assert (red.title, blue.title) == ("R-G", "B-G")
    assert red.places_px.tolist() == [[10.0, 10.0]]
    assert red.before_px.tolist() == [pytest.approx([0.2, 0.0])]
    assert blue.before_px.tolist() == [pytest.approx([-0.2, 0.1])]


def test_the_overview_shows_the_largest_in_the_order_of_image_formation() -> None:
    many = {f"s{i}": numbers(f"s{i}", [{}], [2.0 + i], "codec") for i in range(20)}
    many["detail"] = numbers("detail", [{}], [50.0], "optics")
    svg = overview(many, explained=True)
    assert view_of("detail").title in svg
    assert svg.index(view_of("detail").title) < svg.index("S19")
    assert "S19" in svg
    assert "S0<" not in svg
    assert sum(f"S{i}<" in svg for i in range(20)) == MOST - 1


def test_a_map_averages_what_shares_a_tile() -> None:
    places = [{"box_px": BOX}, {"box_px": BOX}, {"box_px": [20, 0, 40, 20]}]
    svg = image_map("m", numbers("relative_illumination", places, [10, 20, -15]), before="b", after="a")
    assert "+30" in svg  # 100 * 0.02 * 15
    assert "\u221230" in svg


TILES = [{"box_px": [x, y, x + 20, y + 20], "axis": axis} for x in (0, 20) for y in (0, 20) for axis in "xy"]
LINES = [{"level_dn": float(x), "channel": c} for c in "RGB" for x in range(4)]


@pytest.mark.parametrize(
    ("drawn", "told"),
    [
        (
            partial(overview, {"detail": numbers("detail", [{}], [9.0])}, explained=True),
            [view_of("detail").title],
        ),
        (
            partial(arrows, "d", of_tiles(numbers("displacement", TILES, [9.0] * 8)), **CALLED),
            ["was: ", "is: "],
        ),
        (
            partial(image_map, "m", numbers("relative_illumination", TILES, [9.0] * 8), **CALLED),
            ["was", "is"],
        ),
        (
            partial(profile, "p", numbers("level", LINES, [9.0] * 12), "level", **CALLED),
            ["R", "G", "B", "was"],
        ),
    ],
    ids=["overview", "arrows", "map", "profile"],
)
def test_phones_are_told_the_same_in_their_own_width(drawn: Callable[..., str], told: list[str]) -> None:
    wide, narrow = (drawn(narrow=narrow) for narrow in (False, True))
    assert (width_in(wide), width_in(narrow)) == (9.2, NARROW_IN)
    for svg in (wide, narrow):
        words = re.findall(r"<text[^>]*>([^<]*)<", svg)
        assert all(any(word.startswith(each) for word in words) for each in told)


def width_in(svg: str) -> float:
    """Width of a drawing [in]."""
    (width_pt,) = re.findall(r'viewBox="0 0 ([\d.]+) ', svg)
    return round(float(width_pt) / 72, 3)


def test_one_level_is_drawn_capture_by_capture() -> None:
    labels = [Label(f"dark_{i}", "dark", "fixed_pattern", "pixel", {"level_dn": 0.0}) for i in range(2)]
    z = np.array([3.0, -1.0])
    found = Numbers("fixed_pattern", "pixel", labels, z, z, np.ones(2), np.ones(2), 2.0, 2.0)
    svg = profile("p", found, "level", before="b", after=None)
    assert "dark_0" in svg
    assert "dark_1" in svg


def test_maps_take_the_whole_width_where_two_stand_side_by_side() -> None:
    tiles = numbers("relative_illumination", [{"box_px": BOX}], [3.0])
    assert is_wide(tiles)
    assert not is_wide(tiles, compared=False)
    assert mapped(["level", "displacement", "relative_illumination"]) == "displacement"
    assert mapped(["level"]) is None


def test_statistics_nobody_here_knows_are_drawn_in_their_own_words() -> None:
    assert view_of("my_own_number").title == "My own number"
    assert place_words({"from": "R", "to": "G"}) == "R to G"


def test_the_richest_capture_is_shown_and_the_one_that_differs_most() -> None:
    captures = [capture("dark", 0.0), capture("flat", 50.0), capture("flat", 150.0), capture("scene", 90.0)]
    gaps = {"dark_0": (1.0, 1.0), "flat_50": (4.0, 1.0), "flat_150": (9.0, 1.0), "scene_90": (2.0, 1.0)}
    assert [c.id for c in to_show(captures, gaps)] == ["scene_90", "flat_150"]
    quiet = dict.fromkeys(gaps, (1.0, 1.0))
    assert [c.id for c in to_show(captures, quiet)] == ["scene_90"]


def test_the_part_shown_enlarged_is_where_the_frames_differ() -> None:
    (flat,) = taken([capture("flat", 100.0)], [])
    flat.real_dn[:, -30:, -30:] += 60
    shown = compare(flat, (), seed=1)
    assert len(shown.whole) == 2
    assert shown.whole[0].shape == (HEIGHT, WIDTH, 3)
    assert shown.crops[0].shape == (CROP_PX, CROP_PX, 3)
    bright = shown.crops[0].astype(int) - shown.crops[1].astype(int)
    assert bright[-5:, -5:].mean() > bright[:5, :5].mean() + 20


def test_pictures_with_a_tone_curve_of_their_own_are_shown_as_they_are() -> None:
    """A file of a phone is meant for a screen already; a second curve would wash it out."""
    (scene,) = taken([capture("scene", np.linspace(10.0, 230.0, WIDTH))], [])
    linear, of_a_phone = (compare(each, (), seed=1) for each in (scene, replace(scene, coding=CODING)))
    column = WIDTH // 4
    assert of_a_phone.whole[0][:, column].mean() < linear.whole[0][:, column].mean() - 40
    assert np.array_equal(of_a_phone.whole[1], linear.whole[1])


def test_levels_of_a_scene_are_drawn_where_its_pixels_are_not_in_the_middle_of_their_interval() -> None:
    squares = np.where(np.arange(WIDTH) < WIDTH // 2, 10.0, 180.0)
    (edge,) = taken([capture("edge", squares)], [])
    problem = Problem([ImageEvidence(edge, seed=1, replicates=2)])
    found = numbers_of(problem, problem.null, problem.null)["level"]
    assert {label.at["level_dn"] for label in found.labels} <= {26.0, 196.0}
