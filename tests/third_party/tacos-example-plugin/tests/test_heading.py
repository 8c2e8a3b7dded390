"""The task that tells which way the agent goes."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from tacos_framework.testing.samples import sample_episode, sample_rig

from tacos_example.heading import LOST_DEG, Heading, intrinsic_matrix
from tacos_example.point_tracks import Motion, Tracks

CAMERA = sample_rig(width_px=320, height_px=240).cameras[0]


def seen(points_m: NDArray[np.float64]) -> NDArray[np.float32]:
    """(K, 2) pixels of points in the frame of the camera: x right, y down, z ahead."""
    pixels = points_m @ intrinsic_matrix(CAMERA).T
    return (pixels[:, :2] / pixels[:, 2:]).astype(np.float32)


def scores_of(*motions: Motion) -> dict[str, float]:
    scorer = Heading(Heading.Config()).begin(state=None)
    scorer.update(Tracks(sample_episode(), CAMERA, motions))
    return dict(scorer.scores())


@pytest.mark.parametrize("step_m", [(0.0, 0.0, 0.3), (0.2, 0.0, 0.2), (0.0, -0.3, 0.0)])
def test_the_direction_of_exact_points_is_found(step_m: tuple[float, float, float]) -> None:
    points = np.random.default_rng(3).uniform([-2, -1.5, 3], [2, 1.5, 8], (60, 3))
    pose = np.eye(4)
    pose[:3, 3] = step_m
    motion = Motion(seen(points), seen(points - step_m), pose)
    scores = scores_of(motion)
    assert scores["error_deg"] < 1
    assert scores["tracks"] == 60


def test_without_corners_it_is_lost_and_without_motion_it_says_nothing() -> None:
    nowhere = np.empty((0, 2), np.float32)
    assert scores_of(Motion(nowhere, nowhere, np.eye(4))) == {"error_deg": LOST_DEG, "tracks": 0.0}
    assert scores_of() == {}
