"""Chessboards: what no pose explains is the lens."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from tacos_framework.plugins import Plugins
from tacos_framework.values import ImageGeometry
from tacos_gap.boards import BoardEvidence, find_corners
from tacos_gap.captures import Board, CaptureFolder, RealCapture
from tacos_gap.diagnosis import diagnose
from tests.gap.small_captures import capture, placed

SQUARES = Board((9, 6), 25.0)
WIDTH, HEIGHT = 640, 480
FOCAL_PX = 536.0
CENTRE = (319.5, 239.5)
CAMERA = np.array([[FOCAL_PX, 0, CENTRE[0]], [0, FOCAL_PX, CENTRE[1]], [0, 0, 1]])


def view(tilt_deg: tuple[float, float], distance_mm: float) -> tuple[np.ndarray, np.ndarray]:
    """Rotation and translation of a board before the camera."""
    x, y = np.radians(tilt_deg)
    turned = cv2.Rodrigues(np.array([x, 0, 0]))[0] @ cv2.Rodrigues(np.array([0, y, 0]))[0]
    centre = turned @ np.array([100.0, 62.5, 0])
    return cv2.Rodrigues(turned)[0], np.array([0, 0, distance_mm]) - centre


VIEWS = [((0, 0), 240), ((25, 10), 260), ((-20, 25), 250), ((15, -30), 270)]


def seen(tilt_deg: tuple[float, float], distance_mm: float, k1: float = 0.0) -> np.ndarray:
    """(54, 2) corners through a lens with Brown-Conrady distortion, by OpenCV [px]."""
    rows, columns = np.mgrid[:6, :9]
    points = np.column_stack([columns.ravel() * 25.0, rows.ravel() * 25.0, np.zeros(54)])
    rotation, shift = view(tilt_deg, distance_mm)
    return cv2.projectPoints(points, rotation, shift, CAMERA, np.array([k1, 0, 0, 0.0]))[0].reshape(-1, 2)


def board(name: str = "board", image: np.ndarray | None = None) -> RealCapture:
    return replace(
        capture(name, "board", 0.0, frames=1),
        real_dn=np.zeros((1, HEIGHT, WIDTH, 1), np.float32) if image is None else image[None, ..., None],
        expected_dn=None,
        valid=np.ones((HEIGHT, WIDTH), bool),
        geometry=ImageGeometry(WIDTH, HEIGHT, FOCAL_PX, CENTRE, 3.0),
        board=SQUARES,
    )


@pytest.mark.parametrize(("tilt", "distance"), VIEWS)
def test_a_pinhole_is_explained_by_its_pose(tilt, distance):
    evidence = BoardEvidence(board(), seen(tilt, distance), seed=1)
    assert np.abs(evidence.residual(())).max() < 0.05


def test_distortion_is_left_over_and_gone_with_the_right_lens():
    lens = Plugins.discover().resolve("effect.lens-distortion")
    evidence = BoardEvidence(board(), seen((25, 10), 600, k1=-0.3), seed=1)
    assert np.abs(evidence.residual(())).max() > 1.5
    assert np.abs(evidence.residual([placed("lens-distortion", lens, k1=-0.3)])).max() < 0.2
    assert np.abs(evidence.residual([placed("lens-distortion", lens, k1=0.3)])).max() > 3


def drawn(tilt_deg: tuple[float, float], distance_mm: float) -> np.ndarray:
    """(H, W) picture of the board, black squares on white, drawn at four times the size [DN]."""
    image = np.full((HEIGHT * 4, WIDTH * 4), 200, np.uint8)
    rotation, shift = view(tilt_deg, distance_mm)
    large = np.array([[4, 0, 1.5], [0, 4, 1.5], [0, 0, 1]]) @ CAMERA
    for row in range(-1, 6):
        for column in range(-1 + row % 2, 9, 2):
            corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]) + np.array([column, row, 0])
            outline = cv2.projectPoints(corners * 25.0, rotation, shift, large, None)[0]
            cv2.fillConvexPoly(image, np.rint(outline * 16).astype(np.int32), 30, cv2.LINE_AA, 4)
    return cv2.resize(image, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA).astype(np.float32)


def test_corners_are_found_where_the_board_is_drawn():
    found = find_corners(board(image=drawn((15, -10), 300)))
    assert found is not None
    nearest = np.linalg.norm(found[:, None] - seen((15, -10), 300)[None], axis=-1).min(axis=1)
    assert nearest.max() < 0.15


def test_tilted_views_name_the_lens(monkeypatch):
    rng = np.random.default_rng(3)
    corners = {
        f"view {i}": seen(tilt, distance, k1=-0.3) + rng.normal(0, 0.1, (54, 2))
        for i, (tilt, distance) in enumerate(VIEWS)
    }
    monkeypatch.setattr("tacos_gap.diagnosis.find_corners", lambda each: corners[each.id])
    plugins = Plugins.discover()
    names = ("lens-distortion", "focal-length-error", "pose-error", "rolling-shutter")
    effects = {name: plugins.resolve(f"effect.{name}") for name in names}
    folder = CaptureFolder(Path("captures"), tuple(board(name) for name in corners))
    found = diagnose(folder, effects, seed=2)
    assert [cause.effect for cause in found.causes] == ["lens-distortion"]
    k1 = found.causes[0].parameters["k1"]
    assert k1.value == pytest.approx(-0.3, abs=0.06)
    assert k1.interval is not None
    assert k1.interval[0] < -0.3 < k1.interval[1]


def test_a_picture_without_a_board_gives_no_corners():
    noise = np.random.default_rng(1).normal(100, 5, (HEIGHT, WIDTH)).astype(np.float32)
    assert find_corners(board(image=noise)) is None
    assert find_corners(board(image=np.full((HEIGHT, WIDTH), 7, np.float32))) is None
