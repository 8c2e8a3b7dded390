"""Corners are followed, and belong to one walk."""

from __future__ import annotations

from typing import Any

import numpy as np
from tacos_framework.testing import TransformConformance
from tacos_framework.testing.samples import sample_frames

from tacos_example.point_tracks import PointTracks, Tracks


class TestPointTracks(TransformConformance):
    component = PointTracks


def followed(memory: dict[str, Any], frames: int = 4) -> Tracks:
    return PointTracks(PointTracks.Config()).transform(sample_frames(frames=frames), memory=memory)


def test_corners_move_as_the_picture_does() -> None:
    motions = followed({}).motions
    assert len(motions) == 3
    for motion in motions:
        assert len(motion.before_px) >= 8
        step = np.median(motion.after_px - motion.before_px, axis=0)
        np.testing.assert_allclose(step, [-2, 0], atol=0.1)  # the card moves by two pixels a frame


def test_the_frame_before_a_batch_is_remembered_and_of_another_walk_forgotten() -> None:
    memory: dict[str, Any] = {}
    followed(memory)
    assert len(followed(memory).motions) == 4
    memory["walk"] = 7
    assert len(followed(memory).motions) == 3
