"""Semi-global matching: what it finds on planes of known depth, and what becomes of gaps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tacos_framework.formation import frames_for
from tacos_framework.values import FrameBatch, Rig
from tacos_plugins.tasks.sgbm import Sgbm, filled, searched_disparities
from tacos_plugins.tasks.stereo.pair import StereoPair
from tests.tasks.stereo_frames import stereo_frames, stereo_rig

RIG = stereo_rig(width_px=256, height_px=128, focal_length_px=220.0)


def score(frames, **config):
    task = Sgbm(Sgbm.Config(**config))
    scorer = task.begin(state=None)
    scorer.update(frames_for(task, frames))
    return scorer.scores()


@pytest.mark.parametrize("mode", ["sgbm", "3way", "hh"])
def test_textured_planes_are_found(mode):
    found = score(stereo_frames(RIG, 2), mode=mode)
    assert found["log_error"] < 0.05
    assert found["d1"] < 0.03


def test_a_longer_baseline_measures_depth_better():
    short, long = (
        score(stereo_frames(stereo_rig(width_px=256, height_px=128, focal_length_px=220.0, baseline_m=b), 2))
        for b in (0.06, 0.6)
    )
    assert long["log_error"] < 0.5 * short["log_error"]


def test_a_baseline_beyond_the_disparities_searched_fails():
    near = score(stereo_frames(stereo_rig(width_px=256, height_px=128, baseline_m=2.0), 2), max_disparity=16)
    assert near["d1"] > 0.9


def test_noise_tells():
    clean, noisy = (score(stereo_frames(RIG, 2, noise_dn=sigma)) for sigma in (0.0, 60.0))
    assert noisy["log_error"] > 2 * clean["log_error"]


def test_mono_and_sixteen_bits_are_read_alike():
    frames = stereo_frames(RIG, 2, noise_dn=0.0)
    mono = FrameBatch(frames.capture, tuple(image[..., :1] for image in frames.images))
    deep = FrameBatch(
        frames.capture, tuple(image.astype(np.uint16) * 16 + 64 for image in frames.images), 64, 64 + 255 * 16
    )
    assert score(mono) == score(frames) == score(deep)


@pytest.mark.parametrize(
    ("baseline_m", "expected"), [(0.001, 16), (0.12, 32), (0.5, 128), (1.0, 192), (30.0, 192)]
)
def test_disparities_searched_follow_from_the_camera(baseline_m, expected):
    pair = StereoPair(0, 1, width_px=640, height_px=480, focal_length_px=500.0, baseline_m=baseline_m)
    assert searched_disparities(pair, nearest_m=2.0, max_disparity=180) == expected


def test_no_more_disparities_than_columns_are_searched():
    pair = StereoPair(0, 1, width_px=40, height_px=40, focal_length_px=500.0, baseline_m=3.0)
    assert searched_disparities(pair, nearest_m=2.0, max_disparity=192) == 48


def test_gaps_take_the_farther_neighbour():
    given = np.float32([[-1, 4, -1, -1, 2, -1], [-1] * 6, [7, -1, -1, -1, -1, 9]])
    expected = [[4, 4, 2, 2, 2, 2], [4, 4, 2, 2, 2, 2], [7, 7, 7, 7, 7, 9]]
    assert filled(given).tolist() == expected
    assert given[0, 0] == -1


def test_a_frame_without_any_match_is_infinitely_far():
    assert filled(np.full((3, 4), -1, np.float32)).tolist() == [[0.0] * 4] * 3
    flat = stereo_frames(RIG, 1)
    blank = replace(flat, images=tuple(np.full_like(image, 128) for image in flat.images))
    assert score(blank)["rmse_m"] > 900


def test_cameras_that_are_no_pair_are_refused_before_anything_is_rendered():
    task = Sgbm(Sgbm.Config())
    assert task.lacks(RIG) is None
    assert "needs two cameras" in task.lacks(Rig(RIG.cameras[:1]))
    assert "too small" in task.lacks(stereo_rig(width_px=24, height_px=24))
    assert "no camera 'middle'" in Sgbm(Sgbm.Config(left="middle")).lacks(RIG)
