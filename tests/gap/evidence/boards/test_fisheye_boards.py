"""Boards before fisheyes that are known: poses and causes through the lens, as far as it images."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import cv2
import numpy as np
import pytest

from tacos_framework.camera import pixels_of_rays
from tacos_framework.values import ImageGeometry, Lens
from tacos_gap.captures import RealCapture
from tacos_gap.evidence.boards.imaged import imaged
from tacos_gap.evidence.boards.pose import first_pose
from tests.gap.evidence.boards.drawn_boards import SQUARES, board_capture, points
from tests.gap.evidence.boards.test_board_diagnosis import diagnosed, rms
from tests.gap.small_captures import effects_named

T265 = Lens("kannala-brandt", (-0.003, 0.054, -0.052, 0.011))
WIDE = Lens("equidistant", half_field_deg=100)
BEARINGS = [(0, 0), (40, 10), (-55, 30), (72, -20), (-70, -40), (20, 70)]


def believed(lens: Lens) -> ImageGeometry:
    return ImageGeometry(640, 480, 140.0, (319.5, 239.5), 3.0, lens=lens)


def facing(bearing_deg: tuple[float, float], distance_mm: float, tilt_deg: float) -> np.ndarray:
    """(K, 3) corners of a board in a direction off the axis, tilted against it [mm]."""
    printed = points(SQUARES)
    tilt = cv2.Rodrigues(np.radians([tilt_deg, -tilt_deg / 2, 5.0]))[0]
    turn = cv2.Rodrigues(np.array([0, np.radians(bearing_deg[0]), 0]))[0]
    turn = turn @ cv2.Rodrigues(np.array([np.radians(bearing_deg[1]), 0, 0]))[0]
    return ((printed - printed.mean(axis=0)) @ tilt.T + (0, 0, distance_mm)) @ turn.T


def views(real: Lens, known: Lens, noise_px: float = 0.05) -> list[RealCapture]:
    rng = np.random.default_rng(5)
    made = []
    for i, bearing in enumerate(BEARINGS):
        where = pixels_of_rays(facing(bearing, 260.0, 20.0 * (-1) ** i), believed(real))
        where = where + rng.normal(0, noise_px, where.shape)
        assert np.isfinite(where).all()
        capture = board_capture(f"view {i}", corners=(points(SQUARES), where))
        made.append(replace(capture, geometry=believed(known)))
    return made


@pytest.fixture(scope="module")
def effects() -> dict[str, Any]:
    return effects_named("lens-distortion", "focal-length-error", "vignetting")


@pytest.mark.parametrize("lens", [T265, WIDE, Lens("stereographic"), Lens("rectilinear", (-0.1, 0.01))])
def test_derivatives_are_those_of_the_lens(lens):
    where = facing((30, 10), 300.0, 20.0)
    places, moves = imaged(where, believed(lens))
    np.testing.assert_allclose(places, pixels_of_rays(where, believed(lens)))
    step = np.array([0.3, -0.2, 0.1])
    there, _ = imaged(where + step, believed(lens), derivatives=False)
    np.testing.assert_allclose(places + np.einsum("iks,s->ki", moves, step), there, atol=2e-3)


@pytest.mark.parametrize("bearing", BEARINGS)
def test_the_pose_of_a_board_beside_the_camera_is_found(bearing):
    where = facing(bearing, 260.0, 15.0)
    found = first_pose(points(SQUARES), pixels_of_rays(where, believed(WIDE)), believed(WIDE))
    np.testing.assert_allclose(points(SQUARES) @ found.rotation.T + found.shift_mm, where, atol=1e-3)


@pytest.mark.parametrize("lens", [T265, WIDE])
def test_boards_all_around_a_known_fisheye_are_explained_by_their_poses(lens):
    known = views(lens, lens)
    farthest = max(np.hypot(*(c.corners[1] - (319.5, 239.5)).T).max() for c in known)
    assert farthest > 140 * np.radians(80)
    assert rms(known) < 1.1
    assert rms(views(lens, Lens("equisolid"))) > 3


@pytest.mark.parametrize(
    ("real", "known", "beyond"),
    [
        (replace(T265, coefficients=(0.017, *T265.coefficients[1:])), T265, (0.02, 0.0, 0.0, 0.0)),
        pytest.param(T265, Lens("equidistant"), T265.coefficients, marks=pytest.mark.slow),
    ],
)
def test_what_a_known_fisheye_does_beyond_its_calibration_is_its_lens(effects, real, known, beyond):
    found = diagnosed(views(real, known), effects)
    assert [cause.effect for cause in found.causes] == ["lens-distortion"]
    parameters = found.causes[0].parameters
    assert parameters["model"].value == "fisheye"
    for name, wanted in zip(("k1", "k2", "k3", "k4"), beyond, strict=True):
        interval = parameters[name].interval
        low, high = (0.0, 0.0) if interval is None else interval
        assert low - 1e-4 <= wanted <= high + 1e-4, name
