"""The task that looks for a target."""

from __future__ import annotations

import numpy as np
from tacos_framework import FrameBatch
from tacos_framework.testing import TaskConformance
from tacos_framework.testing.samples import sample_frames, sample_rig

from tacos_example.checkerboard import Checkerboard


def frames_with_a_board() -> FrameBatch:
    """Six frames of 320 x 240 px; the first three show a board of 8 x 6 squares."""
    frames = sample_frames(sample_rig(width_px=320, height_px=240))
    images = np.full((6, 240, 320, 1), 200, np.uint8)
    for row in range(6):
        for column in range(8):
            if (row + column) % 2 == 0:
                images[:3, 48 + 24 * row : 72 + 24 * row, 64 + 24 * column : 88 + 24 * column] = 10
    return FrameBatch(frames.capture, (images,))


class TestCheckerboard(TaskConformance):
    component = Checkerboard

    def frames(self) -> FrameBatch:
        return frames_with_a_board()


def test_frames_with_the_board_count() -> None:
    scorer = Checkerboard(Checkerboard.Config()).begin(state=None)
    scorer.update(frames_with_a_board())
    assert scorer.scores() == {"found_ratio": 0.5}


def test_a_board_of_another_size_is_not_found() -> None:
    scorer = Checkerboard(Checkerboard.Config(inner_corners=(9, 5))).begin(state=None)
    scorer.update(frames_with_a_board())
    assert scorer.scores() == {"found_ratio": 0.0}
