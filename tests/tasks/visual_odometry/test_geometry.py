"""Motions from matched rays, against those that made them and against OpenCV's own recovery."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tacos_framework.values import Camera
from tacos_plugins.tasks.consensus import seeded
from tacos_plugins.tasks.visual_odometry.errors import motion_error
from tacos_plugins.tasks.visual_odometry.two_views import motion_between
from tacos_plugins.tasks.visual_odometry.with_depth import motion_of_points, triangulated

CAMERA = Camera("camera", 640, 480, pixel_um=3.0, focal_length_mm=1.2)
F = CAMERA.focal_length_px
RANSAC = {"threshold_px": 1.0, "confidence": 0.999, "seed": 0}


def cloud(seed: int, count: int = 200) -> np.ndarray:
    """Points 2 to 6 m ahead."""
    rng = np.random.default_rng(seed)
    return rng.uniform((-2, -1.5, 2), (2, 1.5, 6), (count, 3))


def motion(turn_rad, step_m) -> np.ndarray:
    made = np.eye(4)
    made[:3, :3], made[:3, 3] = cv2.Rodrigues(np.asarray(turn_rad, float))[0], step_m
    return made


def moved(points, second_from_first) -> np.ndarray:
    return points @ second_from_first[:3, :3].T + second_from_first[:3, 3]


def unit(points) -> np.ndarray:
    return points / np.linalg.norm(points, axis=1, keepdims=True)


def noisy(points, noise_px, seed) -> np.ndarray:
    rng = np.random.default_rng(seed)
    plane = points[:, :2] / points[:, 2:] + rng.standard_normal((len(points), 2)) * noise_px / F
    return unit(np.column_stack([plane, np.ones(len(plane))]))


small = st.floats(-0.3, 0.3)
steps = st.tuples(small, small, small).filter(lambda step: np.linalg.norm(step) > 0.05)


@settings(max_examples=40, deadline=None)
@given(turn=st.tuples(small, small, small), step=steps, seed=st.integers(0, 99))
def test_exact_rays_give_the_exact_motion(turn, step, seed):
    truth, points = motion(turn, step), cloud(seed)
    found, inliers = motion_between(unit(points), unit(moved(points, truth)), F, seeded(**RANSAC))
    error = motion_error(found, truth, least_step_m=0.01, with_length=False)
    assert error.rotation_deg < 0.01
    assert error.direction_deg < 0.2
    assert inliers.mean() > 0.95


def test_a_quarter_of_wrong_matches_changes_little():
    truth, points = motion((0.02, 0.1, -0.03), (0.2, 0.0, 0.1)), cloud(1)
    second = unit(moved(points, truth))
    second[:50] = second[50:100]
    found, inliers = motion_between(unit(points), second, F, seeded(**RANSAC))
    error = motion_error(found, truth, least_step_m=0.01, with_length=False)
    assert error.rotation_deg < 0.02
    assert error.direction_deg < 0.5
    assert inliers[:50].mean() < 0.3


def test_refined_motions_are_no_worse_than_opencvs():
    ours, theirs = [], []
    for seed in range(12):
        truth, points = motion((0.01, 0.08, 0.0), (0.1, 0.02, 0.2)), cloud(seed)
        first, second = noisy(points, 0.5, seed), noisy(moved(points, truth), 0.5, seed + 50)
        found, _ = motion_between(first, second, F, seeded(**RANSAC))
        flat = [rays[:, :2] / rays[:, 2:] for rays in (first, second)]
        essential, mask = cv2.findEssentialMat(*flat, np.eye(3), cv2.RANSAC, 0.999, 1.0 / F)
        other = np.eye(4)
        _, other[:3, :3], step, _ = cv2.recoverPose(essential, *flat, np.eye(3), mask=mask)
        other[:3, 3] = step.ravel()
        for kept, estimate in ((ours, found), (theirs, other)):
            kept.append(motion_error(estimate, truth, least_step_m=0.01, with_length=False).direction_deg)
    assert np.median(ours) <= np.median(theirs)
    assert np.median(ours) < 5


def test_turning_on_the_spot_gives_the_turn():
    truth, points = motion((0.0, 0.2, 0.0), (0, 0, 0)), cloud(3)
    found, _ = motion_between(unit(points), noisy(moved(points, truth), 0.3, 4), F, seeded(**RANSAC))
    assert motion_error(found, truth, least_step_m=0.01, with_length=False).rotation_deg < 0.2


def test_too_few_matches_give_no_motion():
    rays = unit(cloud(0, 7))
    assert motion_between(rays, rays, F, seeded(**RANSAC)) is None
    assert motion_of_points(cloud(0, 4), unit(cloud(0, 4)), F, seeded(**RANSAC)) is None


def test_equal_seeds_give_equal_motions():
    truth, points = motion((0.02, 0.1, -0.03), (0.2, 0.0, 0.1)), cloud(1)
    first, second = noisy(points, 1, 0), noisy(moved(points, truth), 1, 1)
    cv2.setRNGSeed(1)
    one, _ = motion_between(first, second, F, seeded(**RANSAC))
    cv2.setRNGSeed(2)
    other, _ = motion_between(first, second, F, seeded(**RANSAC))
    np.testing.assert_array_equal(one, other)


def test_rays_beside_and_behind_the_camera_and_unseen_ones_change_nothing():
    truth, points = motion((0.02, 0.1, -0.03), (0.2, 0.0, 0.1)), cloud(1)
    first, second = unit(points), unit(moved(points, truth))
    aside = unit(np.array([[1.0, 0.0, -0.2], [0.0, -1.0, 0.0], [np.nan] * 3]))
    wide = [np.concatenate([rays, aside]) for rays in (first, second)]
    alone, _ = motion_between(first, second, F, seeded(**RANSAC))
    beside, inliers = motion_between(*wide, F, seeded(**RANSAC))
    np.testing.assert_array_equal(alone, beside)
    assert not inliers[-3:].any()


@pytest.mark.parametrize("turn_deg", [0, 25])
def test_points_are_triangulated_whatever_way_the_cameras_look(turn_deg):
    left_from_right = motion((0, np.radians(turn_deg), 0), (0.2, 0.0, 0.0))
    points = cloud(2)
    right = moved(points, np.linalg.inv(left_from_right))
    placed, valid = triangulated(unit(points), unit(right), left_from_right, 1 / F)
    assert valid.all()
    np.testing.assert_allclose(placed, points, atol=1e-9)


def test_rays_that_do_not_meet_are_no_point():
    left_from_right = motion((0, 0, 0), (0.2, 0.0, 0.0))
    points = cloud(2)
    right = unit(points - (0.2, 0.0, 0.0))
    _, valid = triangulated(unit(points), np.roll(right, 1, axis=0), left_from_right, 1 / F)
    assert valid.mean() < 0.05


def test_placed_points_give_the_length_too():
    truth, points = motion((0.02, 0.1, -0.03), (0.2, 0.0, 0.1)), cloud(1)
    second = unit(moved(points, truth))
    second[:50] = second[50:100]
    found, inliers = motion_of_points(points, second, F, seeded(**RANSAC))
    error = motion_error(found, truth, least_step_m=0.01, with_length=True)
    assert error.position_share < 1e-4
    assert inliers[50:].all()
