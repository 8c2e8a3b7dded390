"""Stereo pairs and the scores of depth, against numbers worked out by hand."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tacos_framework.camera.geometry import agent_from_camera
from tacos_framework.errors import CandidateFailed
from tacos_framework.values import Lens, Rig
from tacos_plugins.rigs.stereo import StereoRig
from tacos_plugins.tasks.stereo.depth_scores import DepthScores
from tacos_plugins.tasks.stereo.pair import StereoPair, stereo_pair
from tests.tasks.stereo_frames import moved, stereo_rig

PAIR = StereoPair(0, 1, width_px=4, height_px=1, focal_length_px=100.0, baseline_m=0.5)


def pair_of(rig, *, left=None, right=None, smallest_px=32, largest_px=192, max_depth_m=1000.0):
    return stereo_pair(
        rig.cameras,
        left=left,
        right=right,
        smallest_px=smallest_px,
        largest_px=largest_px,
        max_depth_m=max_depth_m,
    )


# pairs ----------------------------------------------------------------------------------------------------


@given(st.floats(0.01, 3), st.floats(50, 120), st.floats(-80, 80))
def test_a_stereo_rig_gives_its_own_baseline_and_focal_length(baseline_m, hfov_deg, pitch_deg):
    sensor = {"width_px": 991, "height_px": 495, "pixel_um": 1.55}
    variables = StereoRig.Variables(
        baseline_m=baseline_m, hfov_deg=hfov_deg, pitch_deg=pitch_deg, sensor=sensor
    )
    pair = pair_of(StereoRig(StereoRig.Config()).build(variables), largest_px=1e9)
    assert pair.baseline_m == pytest.approx(baseline_m)
    assert pair.focal_length_px == pytest.approx(991 / (2 * math.tan(math.radians(hfov_deg / 2))))


def test_depth_and_disparity_undo_each_other():
    depth_m = np.array([0.5, 3.0, 999.0, np.inf], np.float32)
    disparity_px = PAIR.disparity_px(depth_m)
    assert disparity_px.tolist() == pytest.approx([100, 50 / 3, 50 / 999, 0])
    assert PAIR.depth_m(disparity_px, max_depth_m=1000.0).tolist() == pytest.approx([0.5, 3, 999, 1000])


def test_distant_depths_are_told_apart():
    """An 8-bit depth image, as the published code used, has steps of 3.92 m."""
    depth_m = np.array([400.0, 400.5], np.float32)
    back = PAIR.depth_m(PAIR.disparity_px(depth_m), max_depth_m=1000.0)
    np.testing.assert_allclose(back, depth_m, rtol=1e-6)


def test_cameras_may_be_named():
    rig = stereo_rig()
    three = Rig(
        (
            stereo_rig(baseline_m=2.0).cameras[0].__class__(**{**vars(rig.cameras[0]), "name": "nose"}),
            *rig.cameras,
        )
    )
    pair = pair_of(three, left="left", right="right")
    assert (pair.left, pair.right) == (1, 2)
    with pytest.raises(CandidateFailed, match="no camera 'middle', only nose, left, right"):
        pair_of(three, left="middle")


def turned(position_m, yaw):
    pose = agent_from_camera(position_m, pitch_deg=0.0).copy()
    pose[:3, :3] = pose[:3, :3] @ np.array(
        [[math.cos(yaw), 0, math.sin(yaw)], [0, 1, 0], [-math.sin(yaw), 0, math.cos(yaw)]]
    )
    return pose


@pytest.mark.parametrize(
    ("rig", "reason"),
    [
        (Rig(stereo_rig().cameras[:1]), "needs two cameras, and the rig has one: left"),
        (
            Rig(stereo_rig().cameras[::-1]),
            r"'left' stands -0.3 m to the right of 'right', it must be above 0",
        ),
        (stereo_rig(baseline_m=0.0), "'right' stands 0 m to the right of 'left'"),
        (moved(stereo_rig(), 1, focal_length_mm=0.4), "differ in size, focal length or principal point"),
        (moved(stereo_rig(), 1, width_px=120), "differ in size"),
        (moved(stereo_rig(), 1, principal_point_px=(60.0, 31.5)), "principal point"),
        (
            moved(stereo_rig(), 1, agent_from_camera=turned((0.0, -0.15, 0.0), 0.01)),
            "have to be rectified first",
        ),
        (
            moved(stereo_rig(), 1, agent_from_camera=agent_from_camera((0.1, -0.15, 0.0), pitch_deg=0.0)),
            "not parallel and side by side",
        ),
        (
            Rig(tuple(replace(each, lens=Lens("equidistant")) for each in stereo_rig().cameras)),
            "have equidistant lenses: stereo needs rectified images",
        ),
        (stereo_rig(height_px=31), "images of 128 x 31 px are too small for stereo: 32 x 32 px are needed"),
        (
            stereo_rig(focal_length_px=1e6, baseline_m=0.3),
            "a baseline of 0.3 m at 0.00733 deg gives disparities of 300 px and more up to 1000 m",
        ),
    ],
)
def test_what_is_no_pair_is_refused_in_a_sentence(rig, reason):
    with pytest.raises(CandidateFailed, match=reason):
        pair_of(rig)


# scores ---------------------------------------------------------------------------------------------------


def scores_of(disparity_px, depth_m, *, max_depth_m=1000.0):
    scores = DepthScores(max_depth_m)
    scores.add(np.array([disparity_px], np.float32), np.array([depth_m], np.float32), PAIR)
    return scores.scores()


def test_scores_by_hand():
    # truth 5 m is 10 px, 2 m is 25 px, 100 m is 0.5 px; the last is sky
    found = scores_of([5.0, 25.0, 0.0, 0.05], [5.0, 2.0, 100.0, np.inf])
    log_errors = [math.log(2), 0.0, math.log(10), 0.0]  # found: 10 m, 2 m, 1000 m (capped), 1000 m
    squares = [25.0, 0.0, 900.0**2, 0.0]
    assert found["log_error"] == pytest.approx(sum(log_errors[:3]) / 3, rel=1e-6)
    assert found["inverse_log_error"] == pytest.approx(3 / sum(log_errors[:3]), rel=1e-6)
    assert found["rmse_m"] == pytest.approx(math.sqrt(sum(squares[:3]) / 3), rel=1e-6)
    assert found["d1"] == pytest.approx(1 / 3)
    assert found["log_error_all"] == pytest.approx(sum(log_errors) / 4, rel=1e-5)
    assert found["rmse_all_m"] == pytest.approx(math.sqrt(sum(squares) / 4), rel=1e-6)


def test_an_outlier_is_off_by_three_pixels_and_by_five_per_cent():
    # truth 100 px: 5 % are 5 px; truth 10 px: 3 px decide
    assert scores_of([104.0, 106.0], [0.5, 0.5])["d1"] == 0.5
    assert scores_of([12.9, 13.1], [5.0, 5.0])["d1"] == 0.5


def test_the_log_error_is_that_of_disparity_over_baseline():
    truth_px, found_px = np.array([10.0, 3.0, 40.0]), np.array([12.0, 2.0, 41.0])
    expected = np.abs(np.log(truth_px / 0.5) - np.log(found_px / 0.5)).mean()
    found = scores_of(found_px, PAIR.disparity_metre / truth_px)
    assert found["log_error"] == pytest.approx(expected, rel=1e-6)


def test_a_perfect_estimate():
    depth_m = np.array([2.0, 30.0, 999.0])
    found = scores_of(PAIR.disparity_px(depth_m), depth_m)
    assert found["log_error"] < 1e-6
    assert found["inverse_log_error"] == 1000.0
    assert found["d1"] == 0.0


def test_truth_is_capped_where_estimates_are():
    found = scores_of([0.0, 0.0], [1500.0, 999.0])
    assert found["rmse_all_m"] == pytest.approx(math.sqrt(0.5), rel=1e-4)
    assert found["rmse_m"] == pytest.approx(1.0, rel=1e-4)


def test_an_episode_of_sky_has_no_score_but_those_of_all_pixels():
    assert set(scores_of([1.0, 0.0], [np.inf, np.inf])) == {"log_error_all", "rmse_all_m"}


def test_without_frames_there_are_no_scores():
    assert DepthScores(1000.0).scores() == {}


@given(st.lists(st.floats(0.6, 800), min_size=2, max_size=6), st.integers(1, 5))
def test_frames_may_come_in_any_portions(depths_m, cut):
    rng = np.random.default_rng(len(depths_m))
    disparity_px = np.abs(PAIR.disparity_px(np.array(depths_m)) + rng.normal(0, 5, len(depths_m)))
    whole, parts = DepthScores(1000.0), DepthScores(1000.0)
    whole.add(disparity_px[None], np.array([depths_m]), PAIR)
    for run in (slice(None, cut), slice(cut, None)):
        parts.add(disparity_px[None, run], np.array([depths_m])[:, run], PAIR)
    assert parts.scores() == pytest.approx(whole.scores())
