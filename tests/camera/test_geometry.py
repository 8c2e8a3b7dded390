"""Pinhole geometry against OpenCV and by hand."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tacos_framework.camera import geometry
from tacos_framework.values import Camera

angles = st.floats(-80, 80)
offsets = st.floats(-2, 2)


def a_camera(**more):
    return Camera("c", 640, 480, pixel_um=3.0, focal_length_mm=2.0, **more)


@given(angles, angles, offsets, offsets, st.tuples(st.floats(0, 639), st.floats(0, 479)))
def test_projection_agrees_with_opencv(pitch_deg, yaw_deg, x, y, principal_point):
    camera = a_camera(principal_point_px=principal_point)
    pose = geometry.agent_from_camera((x, y, 1.5), pitch_deg, yaw_deg)
    seen = np.array([[0.3, -0.2, 1.0], [-1.0, 0.7, 4.0], [0.0, 0.0, 9.0]])
    points = seen @ pose[:3, :3].T + pose[:3, 3]
    inverse = geometry.invert_pose(pose)
    expected, _ = cv2.projectPoints(
        points, cv2.Rodrigues(inverse[:3, :3])[0], inverse[:3, 3], camera.intrinsics, None
    )
    pixels, depth = geometry.project(points, camera, pose)
    np.testing.assert_allclose(pixels, expected[:, 0], atol=1e-6)
    np.testing.assert_allclose(depth, seen[:, 2], atol=1e-9)


def test_points_behind_the_camera_have_no_pixel():
    pixels, depth = geometry.project([[-1.0, 0.0, 0.0]], a_camera(), geometry.agent_from_camera((0, 0, 0), 0))
    assert np.isnan(pixels).all()
    assert depth[0] < 0


def test_points_beside_the_camera_have_no_pixel_and_close_ones_have():
    pose = geometry.agent_from_camera((0, 0, 0), 0)
    pixels, depth = geometry.project([[0.0, 1.0, 0.0], [0.01, 0.0, 0.0]], a_camera(), pose)
    assert np.isnan(pixels[0]).all()
    assert pixels[1].tolist() == pytest.approx([319.5, 239.5])
    assert depth.tolist() == pytest.approx([0.0, 0.01])


def test_many_poses_are_inverted_at_once():
    poses = np.stack([geometry.agent_from_camera((k, 2, 3), 20 * k, 40) for k in range(3)])
    np.testing.assert_allclose(geometry.invert_pose(poses) @ poses, np.tile(np.eye(4), (3, 1, 1)), atol=1e-12)


def test_poses_and_pixels_keep_double_precision_whatever_they_come_from():
    narrow = np.float32(geometry.agent_from_camera((0.1, 0.2, 0.3), 20.0, 40.0))
    assert geometry.invert_pose(narrow).dtype == np.float64
    exact = narrow.astype(np.float64)
    np.testing.assert_array_equal(geometry.world_from_camera(narrow, narrow), exact @ exact)
    np.testing.assert_array_equal(geometry.world_from_camera(narrow, np.eye(4)), exact)
    assert geometry.world_from_camera(narrow, narrow).dtype == np.float64


@given(angles, angles)
def test_pitch_is_up_and_yaw_is_left(pitch_deg, yaw_deg):
    pose = geometry.agent_from_camera((0, 0, 0), pitch_deg, yaw_deg)
    forward, left, up = pose[:3, 2]
    assert np.degrees(np.arcsin(up)) == pytest.approx(pitch_deg, abs=1e-6)
    assert np.degrees(np.arctan2(left, forward)) == pytest.approx(yaw_deg, abs=1e-6)
    assert np.linalg.det(pose[:3, :3]) == pytest.approx(1.0)
    assert pose[2, 0] == pytest.approx(0.0)  # the image's rows stay level


def test_pixel_rays_project_back_to_their_pixels():
    camera = Camera("c", 7, 5, pixel_um=3.0, focal_length_mm=0.02, principal_point_px=(1.5, 3.0))
    pose = geometry.agent_from_camera((1.0, 2.0, 3.0), 25.0, -40.0)
    points = 3.0 * geometry.pixel_rays(camera) @ pose[:3, :3].T + pose[:3, 3]
    pixels, depth = geometry.project(points, camera, pose)
    np.testing.assert_allclose(pixels[..., 0], np.tile(np.arange(7), (5, 1)), atol=1e-9)
    np.testing.assert_allclose(pixels[..., 1], np.tile(np.arange(5)[:, None], (1, 7)), atol=1e-9)
    np.testing.assert_allclose(depth, 3.0)
