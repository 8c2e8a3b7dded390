"""How the image moves when the camera does."""

from __future__ import annotations

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from tacos_framework.camera.geometry import agent_from_camera, project
from tacos_framework.camera.motion import image_velocity, reprojected
from tacos_framework.testing.samples import sample_world
from tacos_framework.values import Camera, Episode, ImageGeometry, Trajectory, View
from tacos_plugins.effects.pixel_sources import source_of

GEOMETRY = ImageGeometry(64, 48, focal_length_px=50.0, centre_px=(30.0, 25.0), pixel_um=3)


def test_another_camera_sees_points_where_opencv_projects_them():
    rng = np.random.default_rng(3)
    x, y, depth = rng.uniform(0, 60, 40), rng.uniform(0, 45, 40), rng.uniform(1, 9, 40)
    turn, step = np.array([0.05, -0.1, 0.2]), np.array([0.1, -0.05, 0.2])
    transform = np.eye(4)
    transform[:3, :3], transform[:3, 3] = Rotation.from_rotvec(turn).as_matrix(), step
    k = np.array([[50.0, 0, 30.0], [0, 50.0, 25.0], [0, 0, 1]])
    points = depth[:, None] * (np.linalg.inv(k) @ np.stack([x, y, np.ones(40)])).T
    expected, _ = cv2.projectPoints(points, turn, step, k, None)
    there_x, there_y, scale = reprojected(x, y, 1 / depth, GEOMETRY, transform)
    np.testing.assert_allclose(np.stack([there_x, there_y], axis=1), expected[:, 0], atol=1e-9)
    np.testing.assert_allclose(scale * depth, (points @ transform[2, :3]) + step[2])


def test_velocity_is_the_motion_of_projected_points():
    camera = Camera(
        "c", 33, 25, pixel_um=3, focal_length_mm=0.1, agent_from_camera=agent_from_camera((0.1, 0, 0), -10)
    )
    start, end = np.eye(4), np.eye(4)
    end[:3, :3] = Rotation.from_rotvec([0.02, 0.1, 0.2]).as_matrix()
    end[:3, 3] = 1.2, 0.4, -0.1
    trajectory = Trajectory(np.array([0.0, 1.0]), np.stack([start, end]))
    episode = Episode(sample_world(), trajectory, np.array([0.4]), np.zeros(1))
    depth = np.random.default_rng(2).uniform(1, 5, (1, 25, 33)).astype(np.float32)
    pose = trajectory.at(np.array([0.4])) @ camera.agent_from_camera
    view = View(camera, pose, np.ones((1, 25, 33, 3)), depth, np.zeros((1, 25, 33)))
    velocity = image_velocity(view, episode)
    for row, column in [(3, 4), (12, 16), (20, 30)]:
        ray = np.array([*((np.array([column, row]) - camera.centre_px) / camera.focal_length_px), 1.0])
        point = pose[0, :3, :3] @ (ray * depth[0, row, column]) + pose[0, :3, 3]
        places = [
            project(point, camera, trajectory.at(np.array([t]))[0] @ camera.agent_from_camera)[0]
            for t in (0.39, 0.41)
        ]
        np.testing.assert_allclose(
            velocity[0, row, column], (places[1] - places[0]) / 0.02, rtol=0.02, atol=0.05
        )


def test_a_camera_at_rest_sees_nothing_move():
    episode = Episode(
        sample_world(), Trajectory(np.array([0.0]), np.eye(4)[None]), np.array([0.0]), np.zeros(1)
    )
    camera = Camera("c", 8, 6, pixel_um=3, focal_length_mm=0.1)
    view = View(
        camera, np.eye(4)[None], np.ones((1, 6, 8, 3)), np.full((1, 6, 8), np.inf), np.zeros((1, 6, 8))
    )
    np.testing.assert_allclose(image_velocity(view, episode), 0, atol=1e-9)


def test_the_way_back_is_found():
    def forward(x, y):
        return x + 2 + 0.05 * (x - 30), y - 1.5 + 0.02 * (x - 30)

    x, y = source_of(GEOMETRY, forward, frames=2)
    there_x, there_y = forward(x, y)
    np.testing.assert_allclose(there_x, np.broadcast_to(np.arange(64), (2, 48, 64)), atol=1e-5)
    np.testing.assert_allclose(there_y, np.broadcast_to(np.arange(48)[:, None], (2, 48, 64)), atol=1e-5)
