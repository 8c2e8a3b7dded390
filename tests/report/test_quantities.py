"""Numbers as printed, geometry as drawn, pictures as placed."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tacos_report import palette
from tacos_report.pictures import side_by_side
from tacos_report.quantities import duration, measured, number, percent, shown, unit_of, words
from tacos_report.study_data import CameraResult
from tacos_report.view_geometry import floor_range_m, footprint, half_extents, wedge


@given(st.floats(min_value=-1e9, max_value=1e9).filter(lambda value: abs(value) > 1e-5))
def test_a_printed_number_is_right_to_three_digits(value: float) -> None:
    printed = number(value)
    assert "e" not in printed
    assert float(printed.replace("\u202f", "").replace("\u2212", "-")) == pytest.approx(value, rel=0.0051)


@pytest.mark.parametrize(
    ("value", "error", "expected"),
    [
        (3.41834, 0.052, "3.42 ± 0.05"),
        (3.41834, 0.0141, "3.418 ± 0.014"),
        (226.4, 6.8, "226 ± 7"),
        (0.5, None, "0.5"),
        (0.5, 0.0, "0.5"),
        (-0.0001, 0.02, "0.00 ± 0.02"),
    ],
)
def test_the_error_sets_the_digits(value: float, error: float | None, expected: str) -> None:
    assert measured(value, error) == expected


def test_units_and_words_come_from_names() -> None:
    assert shown("focal_length_mm", 2.3612) == "2.36\u202fmm"
    assert shown("pitch_deg", -22.04) == "\u221222°"
    assert shown("sensor", {"name": "IMX178", "pixel_um": 2.4}) == "IMX178"
    assert shown("camera", {"name": "oak_d_w", "title": "OAK-D W"}) == "OAK-D W"
    assert (unit_of("megapixels"), unit_of("gain_db"), unit_of("seed"), unit_of("m")) == ("MP", "dB", "", "")
    assert (words("focal_length_mm"), words("features.inlier_ratio")) == (
        "Focal length",
        "features: inlier ratio",
    )
    assert (percent(0.1834), percent(-0.021)) == ("+18\u202f%", "\u22122.1\u202f%")
    assert (duration(3.21), duration(167.3), duration(7260)) == ("3.2\u202fs", "2 min 47 s", "2 h 1 min")


@given(st.floats(-60, 60), st.floats(-60, 60), st.floats(20, 90), st.floats(20, 90))
def test_a_footprint_is_the_rotation_of_the_frame(
    pitch_deg: float, seen_from_deg: float, hfov_deg: float, vfov_deg: float
) -> None:
    extents = half_extents(hfov_deg, vfov_deg)
    corners = footprint(extents, pitch_deg, seen_from_deg)
    if corners is None:
        return
    turn = math.radians(pitch_deg - seen_from_deg)
    # pitching up about the image's x axis, which points right while y points down
    rotation = np.array(
        [[1, 0, 0], [0, math.cos(turn), -math.sin(turn)], [0, math.sin(turn), math.cos(turn)]]
    )
    ray = rotation @ np.array([extents[0], extents[1], 1.0])
    np.testing.assert_allclose(corners[2], ray[:2] / ray[2], rtol=1e-9, atol=1e-12)


def test_looking_up_moves_the_frame_up() -> None:
    corners = footprint((0.5, 0.4), 10.0, 0.0)
    assert corners is not None
    assert np.mean([y for _, y in corners]) < -0.1


def test_the_floor_seen() -> None:
    assert floor_range_m(1.5, 30.0, 40.0) is None
    assert floor_range_m(1.5, 0.0, 90.0) == pytest.approx((1.5, math.inf))
    assert floor_range_m(1.5, -80.0, 40.0) == pytest.approx((0.0, 1.5 / math.tan(math.radians(60))))


def test_a_wedge_stops_at_the_floor() -> None:
    assert min(z for _, z in wedge((0.0, 1.5), -80.0, 20.0, 5.0, floor=0.0)) == pytest.approx(0.0)


def test_frames_side_by_side_share_one_angular_scale_and_one_horizon() -> None:
    level = CameraResult("a", "a", {"pitch_deg": 0.0}, {"hfov_deg": 90.0, "vfov_deg": 60.0})
    down = CameraResult("b", "b", {"pitch_deg": -20.0}, {"hfov_deg": 53.13010235, "vfov_deg": 40.0})
    wide, narrow = side_by_side([level, down], gap=2.0)
    assert wide.width / narrow.width == pytest.approx(2.0)
    assert wide.width + narrow.width == pytest.approx(98.0)
    scale = wide.width / 2  # percent per focal length
    above_horizon_of_down = math.tan(math.radians(20)) - math.tan(math.radians(20))
    above_horizon_of_level = math.tan(math.radians(30))
    assert wide.top == 0.0
    assert narrow.top == pytest.approx((above_horizon_of_level - above_horizon_of_down) * scale)


def test_every_camera_keeps_its_colour_and_the_designed_one_stays_alone() -> None:
    colours = [palette.camera_colour(index) for index in range(9)]
    assert colours.count(colours[0]) == 1
    assert len(set(colours[:6])) == 6
    assert palette.tinted(f"fill: {colours[2]}; stroke: #123456") == "fill: var(--camera-2); stroke: #123456"
    assert not set(palette.TERMS) & set(colours)
