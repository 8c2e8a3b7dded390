"""The motion of a camera from its images of a textured room."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from tacos_framework.formation import frames_for
from tacos_framework.testing import TaskConformance
from tacos_framework.values import Capture, FrameBatch, Rig
from tacos_plugins.tasks.visual_odometry.task import VisualOdometry
from tests.tasks.visual_odometry.walked_room import rig, room_frames, walk

MONO = Rig(rig().cameras[:1])


def score(frames: FrameBatch, **config):
    task = VisualOdometry(VisualOdometry.Config(**config))
    scorer = task.begin(state=None)
    scorer.update(frames_for(task, frames))
    return scorer.scores()


class TestVisualOdometry(TaskConformance):
    component = VisualOdometry
    config = {"stereo": True}  # noqa: RUF012 - as plugin authors write it

    def frames(self) -> FrameBatch:
        return room_frames(walk(4))


@pytest.mark.parametrize("features", ["klt", "orb"])
def test_a_walk_through_a_textured_room_is_followed(features):
    scores = score(room_frames(walk(6), MONO), features=features)
    assert scores["tracked"] == scores["within_1_deg"] == 1
    assert scores["rotation_error_deg"] < 0.3
    assert scores["direction_error_deg"] < (6 if features == "klt" else 20)
    assert "position" not in scores


def test_two_cameras_know_the_length():
    scores = score(room_frames(walk(6)), stereo=True)
    assert scores["tracked"] == 1
    assert scores["drift"] < 0.06
    assert scores["rotation_error_deg"] < 0.1


def test_a_long_baseline_drifts_less():
    drifts = [
        score(room_frames(walk(6), rig(baseline_m=metres)), stereo=True)["drift"] for metres in (0.01, 0.2)
    ]
    assert drifts[0] > 1.5 * drifts[1]


def test_blur_and_noise_cost_grades():
    sharp = score(room_frames(walk(6), MONO))
    blurred = score(room_frames(walk(6), MONO, blur_px=15))
    noisy = score(room_frames(walk(6), MONO, noise_dn=40))
    assert sharp["rotation"] > blurred["rotation"] + 0.05
    assert sharp["rotation"] > noisy["rotation"] + 0.05


def test_more_pixels_are_right_to_a_smaller_angle():
    small, large = (
        score(room_frames(walk(6), Rig(rig(width, height).cameras[:1])))
        for width, height in ((160, 120), (640, 480))
    )
    assert large["rotation"] > small["rotation"] + 0.1


def test_nothing_to_follow_is_lost():
    frames = room_frames(walk(3), MONO)
    blank = replace(frames, images=(np.full_like(frames.images[0], 90),))
    scores = score(blank)
    assert scores["tracked"] == scores["rotation"] == scores["direction"] == 0
    assert scores["rotation_error_deg"] == 180


def test_windows_chain_their_steps():
    frames = room_frames(walk(6), MONO)
    pairs, windows = score(frames), score(frames, window=4)
    assert pairs["rotation_error_deg"] < windows["rotation_error_deg"] < 0.1


@pytest.mark.parametrize(
    "changes", [{"walk": np.arange(3, dtype=np.int32)}, {"time_s": np.array([0.0, 0.5, 1.0])}]
)
def test_frames_of_other_walks_and_late_ones_are_no_pairs(changes):
    frames = room_frames(walk(3), MONO)
    capture = frames.capture
    apart = replace(frames, capture=Capture(replace(capture.episode, **changes), capture.views))
    assert score(apart, pair_within_s=0.15) == {}


def test_one_camera_is_no_stereo_pair():
    stereo = VisualOdometry(VisualOdometry.Config(stereo=True))
    assert "the rig has one camera" in stereo.lacks(MONO)
    assert stereo.lacks(rig()) is None


@pytest.mark.parametrize("stereo", [False, True])
@pytest.mark.parametrize("blur_px", [0, 5], ids=["white", "coloured"])
def test_motions_of_pure_noise_are_lost(stereo, blur_px):
    frames = room_frames(walk(8))
    rng = np.random.default_rng(2)
    noise = [
        np.stack([noise_image(rng, blur_px, image.shape[1:3]) for _ in range(len(image))])[..., None]
        for image in frames.images
    ]
    scores = score(replace(frames, images=tuple(noise)), stereo=stereo)
    assert scores["tracked"] == scores["rotation"] == scores["direction"] == 0


def noise_image(rng: np.random.Generator, blur_px: int, shape: tuple[int, ...]) -> np.ndarray:
    noise = rng.normal(0, 30, shape)
    smooth = cv2.GaussianBlur(noise, (blur_px, blur_px), 0) if blur_px else noise
    return np.clip(60 + smooth, 0, 255).astype(np.uint8)


@pytest.mark.parametrize("stereo", [False, True])
def test_dim_frames_of_a_true_walk_are_followed(stereo):
    """A sixteenth of the contrast under noise of a quarter of that."""
    frames = room_frames(walk(6))
    rng = np.random.default_rng(3)
    dim = [
        np.clip(image / 16.0 + 20 + rng.normal(0, 1, image.shape), 0, 255).round().astype(np.uint8)
        for image in frames.images
    ]
    scores = score(replace(frames, images=tuple(dim)), stereo=stereo)
    assert scores["tracked"] == scores["within_1_deg"] == 1
