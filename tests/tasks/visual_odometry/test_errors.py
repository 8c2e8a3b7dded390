"""Errors of motions, and what becomes of them as scores."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tacos_plugins.tasks.visual_odometry.errors import (
    POSITION_SHARE,
    ROTATION_DEG,
    MotionError,
    grade,
    motion_error,
    scores_of,
)

vectors = st.tuples(*[st.floats(-1, 1)] * 3)


@given(one=vectors, other=vectors)
def test_the_rotation_error_is_the_angle_between_the_rotations(one, other):
    poses = [np.eye(4), np.eye(4)]
    turns = [Rotation.from_rotvec(each) for each in (one, other)]
    for pose, turn in zip(poses, turns, strict=True):
        pose[:3, :3] = turn.as_matrix()
    error = motion_error(*poses, least_step_m=0.02, with_length=False)
    expected = np.degrees((turns[0].inv() * turns[1]).magnitude())
    assert error.rotation_deg == pytest.approx(expected, abs=1e-5)
    assert error.direction_deg is None  # the camera stood still


@given(error=st.floats(0, 1e6), factor=st.floats(1, 100))
def test_grades_lie_between_0_and_1_and_fall_with_the_error(error, factor):
    assert 0 <= grade(error * factor, ROTATION_DEG) <= grade(error, ROTATION_DEG) <= 1


def test_ten_times_the_error_costs_equal_parts():
    assert grade(0.1, ROTATION_DEG) - grade(1.0, ROTATION_DEG) == pytest.approx(1 / 4)
    assert grade(0.01, POSITION_SHARE) == pytest.approx(2 / 3)


def test_a_lone_outlier_moves_the_mean_grade_by_its_share_at_most():
    good = [MotionError(True, 0.1, 1.0, None)] * 9
    for outlier in (MotionError(True, 30.0, 90.0, None), MotionError(False, 180.0, 180.0, None)):
        with_it, without = scores_of([*good, outlier]), scores_of([*good, good[0]])
        assert without["rotation"] - with_it["rotation"] <= 0.1
        assert with_it["rotation_error_deg"] == without["rotation_error_deg"]


def test_a_lost_motion_counts_as_the_worst():
    truth = np.eye(4)
    truth[0, 3] = 1.0
    lost = motion_error(None, truth, least_step_m=0.02, with_length=True)
    scores = scores_of([lost])
    assert scores["tracked"] == scores["rotation"] == scores["direction"] == scores["position"] == 0
    assert scores["drift"] == 1


def test_nothing_seen_is_no_score():
    assert scores_of([]) == {}
