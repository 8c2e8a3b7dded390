"""Geometry of cameras: from the agent's pose to pixels and back.

Frames: agent x forward, y left, z up; camera x right, y down, z forward (OpenCV). A pose
``a_from_b`` takes homogeneous points of frame b to frame a. Pixel (0, 0) has its centre at (0.0, 0.0).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tacos_framework.camera.projection import Projecting, pixels_of_rays, rays_of_pixels
from tacos_framework.values import Camera

AGENT_FROM_LEVEL_CAMERA: NDArray[np.float64] = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
"""(3, 3) rotation of a camera that looks straight ahead along the agent's x axis."""
AGENT_FROM_LEVEL_CAMERA.flags.writeable = False


def agent_from_camera(
    position_m: Sequence[float] | NDArray[np.float64], pitch_deg: float, yaw_deg: float = 0.0
) -> NDArray[np.float64]:
    """The pose of a camera mounted on the agent.

    - `position_m`: (3,) optical centre in the agent frame: forward, left, up [m].
    - `pitch_deg`: tilt of the optical axis, positive is up [deg].
    - `yaw_deg`: turn of the optical axis, positive is left [deg].

    Returns: (4, 4) float64 rigid transform [m].

    >>> pose = agent_from_camera((0.0, 0.0, 0.1), pitch_deg=30.0)
    >>> (pose @ [0, 0, 1, 1]).round(3).tolist()  # one metre along the optical axis
    [0.866, 0.0, 0.6, 1.0]
    """
    pitch, yaw = math.radians(pitch_deg), math.radians(yaw_deg)
    turn_left = np.array(
        [[math.cos(yaw), -math.sin(yaw), 0.0], [math.sin(yaw), math.cos(yaw), 0.0], [0.0, 0.0, 1.0]]
    )
    tilt_up = np.array(
        [[math.cos(pitch), 0.0, -math.sin(pitch)], [0.0, 1.0, 0.0], [math.sin(pitch), 0.0, math.cos(pitch)]]
    )
    pose = np.eye(4)
    pose[:3, :3] = turn_left @ tilt_up @ AGENT_FROM_LEVEL_CAMERA
    pose[:3, 3] = position_m
    return pose


def world_from_camera(
    world_from_agent: NDArray[np.float64], agent_from_camera: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Camera poses in the world.

    `world_from_agent`: (..., 4, 4) poses of the agent [m]. `agent_from_camera`: (4, 4) pose of the camera on
    the agent [m].

    Returns: (..., 4, 4) float64 [m].

    >>> walk = np.tile(np.eye(4), (2, 1, 1))
    >>> walk[1, 0, 3] = 5.0
    >>> world_from_camera(walk, agent_from_camera((0, 0, 0), 0.0))[:, :3, 3].tolist()
    [[0.0, 0.0, 0.0], [5.0, 0.0, 0.0]]
    """
    return np.asarray(world_from_agent, dtype=np.float64) @ np.asarray(agent_from_camera, dtype=np.float64)


def invert_pose(pose: NDArray[np.float64]) -> NDArray[np.float64]:
    """The inverse of (..., 4, 4) rigid transforms: ``b_from_a`` of ``a_from_b`` [m].

    >>> pose = agent_from_camera((1.0, 2.0, 3.0), pitch_deg=20.0, yaw_deg=40.0)
    >>> bool(np.allclose(invert_pose(pose) @ pose, np.eye(4)))
    True
    """
    inverse = np.zeros_like(pose, dtype=np.float64)
    rotation = np.swapaxes(pose[..., :3, :3], -1, -2)
    inverse[..., :3, :3] = rotation
    inverse[..., :3, 3] = -np.einsum("...ij,...j->...i", rotation, pose[..., :3, 3])
    inverse[..., 3, 3] = 1.0
    return inverse


def project(
    points_m: ArrayLike, camera: Camera, world_from_camera: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Places of points of the world in the image of a camera.

    `points_m`: (..., 3) points in the world [m]. `world_from_camera`: (4, 4) its pose [m].

    Returns:

    - `pixels_px`: (..., 2) float64 pixel coordinates (x, y), not clipped to the image; NaN for points that
      the lens does not image, as those behind a rectilinear camera [px].
    - `depth_m`: (...) float64 depth as `View.depth_m` has it; negative behind a rectilinear camera [m].

    >>> camera = Camera("c", width_px=5, height_px=5, pixel_um=10, focal_length_mm=1)
    >>> pose = agent_from_camera((0, 0, 0), pitch_deg=0)
    >>> pixels, depth = project([[2.0, 0.0, 0.0], [2.0, 0.02, 0.02]], camera, pose)
    >>> pixels.round(6).tolist(), depth.tolist()
    ([[2.0, 2.0], [1.0, 1.0]], [2.0, 2.0])
    """
    points = np.asarray(points_m, dtype=np.float64)
    camera_from_world = invert_pose(world_from_camera)
    seen = points @ camera_from_world[:3, :3].T + camera_from_world[:3, 3]
    return pixels_of_rays(seen, camera), depth_of(seen, camera)


def depth_of(points_m: NDArray[np.float64], camera: Projecting) -> NDArray[np.float64]:
    """(...) depth as `View.depth_m` has it, of (..., 3) points in the camera frame [m]."""
    return points_m[..., 2] if camera.lens.is_rectilinear else np.linalg.norm(points_m, axis=-1)


def pixel_rays(camera: Camera) -> NDArray[np.float64]:
    """Points that pixel centres see at a depth of 1, in the camera frame.

    A point at depth Z of a pixel (`View.depth_m`) is ``Z * ray`` [m]: rays of rectilinear cameras are scaled
    to z = 1, those of others have unit length.

    Returns: (H, W, 3) float64; NaN outside of the image circle [1].

    >>> camera = Camera("c", width_px=3, height_px=1, pixel_um=10, focal_length_mm=0.01)
    >>> pixel_rays(camera).tolist()
    [[[-1.0, 0.0, 1.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0]]]
    """
    if not camera.lens.is_pinhole:
        x, y = np.meshgrid(np.arange(camera.width_px), np.arange(camera.height_px))
        rays = rays_of_pixels(np.stack([x, y], axis=-1), camera)
        return rays / rays[..., 2:] if camera.lens.is_rectilinear else rays
    cx, cy = camera.centre_px
    rays = np.ones((camera.height_px, camera.width_px, 3))
    rays[..., 0] = (np.arange(camera.width_px) - cx) / camera.focal_length_px
    rays[..., 1] = ((np.arange(camera.height_px) - cy) / camera.focal_length_px)[:, None]
    return rays


def along_axis_m(depth_m: NDArray[np.floating], camera: Camera) -> NDArray[np.float64]:
    """The distance along the optical axis of what has a depth (`View.depth_m`); negative behind the camera.

    `depth_m`: (..., H, W) depth, infinite where nothing is [m].

    Returns: (..., H, W); infinite where nothing is [m].
    """
    return _times(depth_m, pixel_rays(camera)[..., 2])


def distance_m(depth_m: NDArray[np.floating], camera: Camera) -> NDArray[np.float64]:
    """The distance from the optical centre of what has a depth, likewise [m].

    >>> camera = Camera("c", width_px=3, height_px=1, pixel_um=10, focal_length_mm=0.01)
    >>> distance_m(np.ones((1, 3)), camera).round(3).tolist()
    [[1.414, 1.0, 1.414]]
    """
    return _times(depth_m, np.linalg.norm(pixel_rays(camera), axis=-1))


def _times(depth_m: NDArray[np.floating], scale: NDArray[np.float64]) -> NDArray[np.float64]:
    with np.errstate(invalid="ignore"):
        return np.where(np.isfinite(depth_m), np.asarray(depth_m, np.float64) * scale, np.inf)
