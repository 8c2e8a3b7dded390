"""Fisheyes from the bench to the cause: boards rendered through the lens, found, diagnosed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from tacos_framework.plugins import Plugins
from tacos_framework.settings import check
from tacos_framework.values import Lens
from tacos_gap.captures import CaptureFolder, RealCapture
from tacos_gap.captures.reader import read_captures
from tacos_gap.captures.writer import write_captures
from tacos_gap.evidence.boards import boards_found
from tacos_gap.simulation.bench import BenchSettings, CaptureBench
from tests.gap.evidence.boards.test_board_diagnosis import diagnosed
from tests.gap.small_captures import effects_named

pytestmark = pytest.mark.slow

T265 = (-0.003, 0.054, -0.052, 0.011)
CENTRE = (424.4, 398.6)
PLACES = [
    (0.25, 0, 0, 0, 0),
    (0.15, 0.25, 0, 0, -58),
    (0.15, -0.25, 0, 0, 58),
    (0.15, 0, 0.22, -55, 0),
    (0.15, 0, -0.22, 55, 0),
    (0.3, 0.1, 0.1, 0, 30),
    (0.25, -0.12, -0.1, -25, 15),
]
"""Distance, right, up [m], tilt and turn [deg] of each board."""
BESIDE = [(0.17, side * 0.42, 0, 0, -side * 68) for side in (1, -1)]
"""Boards with corners 80 deg off the axis of a camera of 190 deg."""
SENSOR: dict[str, Any] = {"name": "small", "width_px": 848, "height_px": 800, "pixel_um": 3.0}


@pytest.fixture(scope="module")
def effects() -> dict[str, Any]:
    return effects_named("lens-distortion", "focal-length-error", "pose-error", "vignetting")


def boards_seen_by(rig: dict[str, Any], places: Sequence[tuple[float, ...]], folder: Path) -> CaptureFolder:
    """Two frames of a board at each of (N, 5) `places`, in which the corners are found."""
    names = ("distance_m", "right_m", "up_m", "tilt_deg", "turn_deg")
    described = {
        "rig": {"use": "rig.monocular", "sensor": SENSOR, **rig},
        "renderer": {"use": "renderer.moderngl"},
        "sensor": {"use": "sensor.affine-noise", "calibration": "flea3_imx172", "black_level_dn": 16},
        "captures": [
            {
                "id": f"board_{i}",
                "kind": "board",
                "scene": {"use": "scene.chessboard", **dict(zip(names, place, strict=True))},
                "frames": 2,
            }
            for i, place in enumerate(places)
        ],
    }
    settings, faults, _ = check(BenchSettings, described, str)
    assert settings is not None, faults
    write_captures(folder, CaptureBench(settings, Plugins.discover(), seed=1).captures())
    return boards_found(read_captures(folder))


@pytest.fixture(scope="module")
def boards(tmp_path_factory: pytest.TempPathFactory) -> CaptureFolder:
    calibration = {
        "width_px": 848,
        "height_px": 800,
        "focal_length_px": 282.0,
        "centre_px": [*CENTRE],
        "projection": "kannala-brandt",
        "coefficients": [*T265],
    }
    rig = {"calibration": calibration, "image_circle_deg": 163}
    return boards_seen_by(rig, PLACES, tmp_path_factory.mktemp("t265"))


@pytest.fixture(scope="module")
def wide_boards(tmp_path_factory: pytest.TempPathFactory) -> CaptureFolder:
    half_field_rad = math.radians(95)
    focal_length_mm = SENSOR["width_px"] / 2 / half_field_rad * SENSOR["pixel_um"] * 1e-3
    rig = {"focal_length_mm": focal_length_mm, "projection": "equidistant"}
    return boards_seen_by(rig, [*PLACES, *BESIDE], tmp_path_factory.mktemp("equidistant"))


def believing(captures: Sequence[RealCapture], **changes: Any) -> list[RealCapture]:
    return [replace(each, geometry=replace(each.geometry, **changes)) for each in captures]


def test_its_own_calibration_leaves_nothing_to_name(boards, effects):
    assert len(boards.captures) == len(PLACES)
    assert boards.captures[0].geometry.lens.coefficients == T265
    found = diagnosed(boards.captures, effects)
    assert found.verdict == "no_gap"


def test_another_first_coefficient_is_found_with_its_value(boards, effects):
    other = Lens("kannala-brandt", (0.017, *T265[1:]))
    found = diagnosed(believing(boards.captures, lens=other), effects)
    assert [cause.effect for cause in found.causes] == ["lens-distortion"]
    interval = found.causes[0].parameters["k1"].interval
    assert interval is not None
    assert interval[0] <= -0.02 <= interval[1]


def test_all_coefficients_of_a_lens_taken_for_equidistant_are_found(boards, effects):
    found = diagnosed(believing(boards.captures, lens=Lens("equidistant")), effects)
    assert [cause.effect for cause in found.causes] == ["lens-distortion"]
    for name, truth in zip(("k1", "k2", "k3", "k4"), T265, strict=True):
        interval = found.causes[0].parameters[name].interval
        assert interval is not None
        assert interval[0] <= truth <= interval[1], name


def test_another_principal_point_is_found_where_it_is(boards, effects):
    found = diagnosed(believing(boards.captures, centre_px=(CENTRE[0] - 3, CENTRE[1] + 1.5)), effects)
    assert [cause.effect for cause in found.causes] == ["focal-length-error"]
    for name, truth in (("dx_px", 3.0), ("dy_px", -1.5)):
        interval = found.causes[0].parameters[name].interval
        assert interval is not None
        assert interval[0] <= truth <= interval[1], name


def test_boards_beside_a_camera_of_190_degrees_are_found_and_leave_nothing_to_name(wide_boards, effects):
    assert len(wide_boards.captures) == len(PLACES) + len(BESIDE)
    assert wide_boards.captures[0].geometry.lens.projection == "equidistant"
    assert diagnosed(wide_boards.captures, effects).verdict == "no_gap"


@pytest.mark.parametrize("believed", [Lens("kannala-brandt", (0.02, 0.0, 0.0, 0.0)), Lens("stereographic")])
def test_another_lens_of_190_degrees_is_found_by_its_boards(wide_boards, effects, believed):
    found = diagnosed(believing(wide_boards.captures, lens=believed), effects)
    assert [cause.effect for cause in found.causes] == ["lens-distortion"]
    if believed.coefficients:
        interval = found.causes[0].parameters["k1"].interval
        assert interval is not None
        assert interval[0] <= -0.02 <= interval[1]
