"""Corners of rendered boards lie where the closed form has them."""

from __future__ import annotations

import numpy as np
import pytest

from tacos_framework.camera import project
from tacos_framework.plugins import Plugins
from tacos_framework.settings import check
from tacos_framework.values import Camera, Lens
from tacos_gap.evidence.boards.detection import find_corners
from tacos_gap.simulation.bench import BenchSettings, CaptureBench
from tacos_gap.simulation.bench.fine_pictures import FINER, finer
from tacos_worlds.bench.chessboard import IN_FRONT_M

SQUARE_M, DISTANCE_M = 0.025, 0.3
LENSES = {
    "rectilinear": {"focal_length_mm": 1.0},
    "equidistant": {"focal_length_mm": 1.0, "projection": "equidistant"},
}


@pytest.mark.parametrize("lens", LENSES)
def test_corners_of_a_board_that_faces_the_camera_are_where_they_are_projected(lens: str) -> None:
    described = {
        "rig": {
            "use": "rig.monocular",
            "sensor": {"name": "small", "width_px": 480, "height_px": 400, "pixel_um": 3.0},
            **LENSES[lens],
        },
        "renderer": {"use": "renderer.moderngl"},
        "sensor": {"use": "sensor.affine-noise", "calibration": "flea3_imx172", "black_level_dn": 16},
        "captures": [
            {
                "id": "board",
                "kind": "board",
                "scene": {"use": "scene.chessboard", "distance_m": DISTANCE_M, "right_m": 0.013},
                "frames": 2,
            }
        ],
    }
    settings, faults, _ = check(BenchSettings, described, str)
    assert settings is not None, faults
    bench = CaptureBench(settings, Plugins.discover(), seed=1)
    (shot,) = bench.shots.values()
    view = bench.expected(shot).light.views[0]
    across, up = np.meshgrid(np.arange(-4, 5) * SQUARE_M + 0.013, np.arange(-2.5, 3) * SQUARE_M)
    points = np.stack([np.full(across.size, DISTANCE_M - IN_FRONT_M), -across.ravel(), up.ravel()], axis=1)
    wanted = np.array([project(point, view.camera, view.world_from_camera[0])[0] for point in points])
    corners = find_corners(bench.capture(shot))
    assert corners is not None
    off = corners[1][:, None] - wanted
    nearest = off[np.arange(len(off)), np.linalg.norm(off, axis=-1).argmin(axis=1)]
    assert len(nearest) == 54
    assert np.sqrt((nearest**2).mean()) < 0.1
    assert np.abs(nearest.mean(axis=0)).max() < 0.05


def test_a_finer_camera_sees_the_same() -> None:
    camera = Camera("c", 64, 48, 3.0, 0.1, lens=Lens("equidistant"), principal_point_px=(30.0, 25.5))
    fine = finer(camera)
    assert fine.focal_length_px == pytest.approx(FINER * camera.focal_length_px)
    where = np.array([0.3, -0.2, 1.0])
    pose = np.eye(4)
    here, there = (np.array(project(where, each, pose)[0]) for each in (camera, fine))
    np.testing.assert_allclose((there + 0.5) / FINER - 0.5, here)
