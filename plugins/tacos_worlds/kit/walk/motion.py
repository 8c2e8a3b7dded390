"""From a path on the floor to head poses over time."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d
from scipy.spatial.transform import Rotation

from tacos_worlds.kit.walk.route import STEP_M, Route

KEY_RATE_HZ = 20.0
"""Poses per second of a trajectory [Hz]."""
MAX_YAW_RATE_DEG_S = 60.0
"""The agent slows down in bends to turn no faster than this [deg/s]."""
_YAW_SMOOTHING_S = 0.35
_HEADING_POINTS = 6
"""Points of the path over which heading and speed are smoothed [1]."""
_STEP_LENGTH_M = 0.7
_BOB_M = 0.012
_SWAY_M = 0.012


@dataclass(frozen=True, eq=False)
class Walk:
    """One continuous walk."""

    time_s: NDArray[np.float64]  # (K,) times of the poses from 0 [s]
    world_from_agent: NDArray[np.float64]  # (K, 4, 4) poses of the head [m]
    crossings: tuple[tuple[float, int], ...]  # (time [s], door) for each doorway, in order

    @property
    def duration_s(self) -> float:
        return float(self.time_s[-1])

    def raised(self, by_m: float) -> Walk:
        """The same walk with the eye so much higher [m]."""
        poses = self.world_from_agent.copy()
        poses[:, 2, 3] += by_m
        return replace(self, world_from_agent=poses)


def draw_walk(
    rng: np.random.Generator,
    route: Route,
    *,
    speed_m_s: float,
    camera_height_m: float,
    floor_m: NDArray[np.float64] | None = None,
) -> Walk:
    """Walk along a route: slower in bends, the head turned along the way, now and then looking around.

    `floor_m` is the height of the floor at each point of the route; zero by default [m].
    """
    time_at_point, heading_at_point = _schedule(route.points_m, speed_m_s)
    time_s = np.arange(0, time_at_point[-1], 1 / KEY_RATE_HZ)
    x = np.interp(time_s, time_at_point, route.points_m[:, 0])
    y = np.interp(time_s, time_at_point, route.points_m[:, 1])
    heading = np.interp(time_s, time_at_point, heading_at_point)
    heading = gaussian_filter1d(heading, _YAW_SMOOTHING_S * KEY_RATE_HZ, mode="nearest")
    yaw = heading + _looking_around(rng, time_s, np.array([time_at_point[k] for k, _ in route.door_at]))

    stride = (
        2
        * math.pi
        * np.interp(time_s, time_at_point, np.arange(len(time_at_point)) * STEP_M)
        / _STEP_LENGTH_M
    )
    z = camera_height_m + _BOB_M * np.sin(stride) + _drift(rng, len(time_s), 0.008)
    if floor_m is not None:
        z += np.interp(time_s, time_at_point, floor_m)
    sway = _SWAY_M * np.sin(stride / 2)
    pitch = _drift(rng, len(time_s), math.radians(1.2)) + math.radians(0.25) * np.sin(stride + 0.7)
    roll = _drift(rng, len(time_s), math.radians(0.5)) + math.radians(0.3) * np.sin(stride / 2 + 0.4)

    poses = np.tile(np.eye(4), (len(time_s), 1, 1))
    # Intrinsic yaw (left), pitch (up is positive, so about -y), roll.
    poses[:, :3, :3] = Rotation.from_euler("ZYX", np.stack([yaw, -pitch, roll], axis=1)).as_matrix()
    poses[:, 0, 3] = x - sway * np.sin(heading)
    poses[:, 1, 3] = y + sway * np.cos(heading)
    poses[:, 2, 3] = z
    crossings = tuple((float(time_at_point[k]), door) for k, door in route.door_at)
    return Walk(time_s, poses, crossings)


def _schedule(
    points_m: NDArray[np.float64], speed_m_s: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(N,) time [s] and heading [rad] at each point, slow in bends to keep the limit of the yaw rate."""
    steps = np.diff(points_m, axis=0)
    along = np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))
    heading = gaussian_filter1d(np.concatenate([along, along[-1:]]), _HEADING_POINTS, mode="nearest")
    at_speed = np.linalg.norm(steps, axis=1) / speed_m_s
    at_yaw_rate = np.abs(np.diff(heading)) / math.radians(MAX_YAW_RATE_DEG_S)
    needed = np.maximum(at_speed, at_yaw_rate)
    eased = np.maximum(gaussian_filter1d(needed, _HEADING_POINTS, mode="nearest"), needed)
    return np.concatenate([[0], np.cumsum(np.maximum(eased, 1e-6))]), heading


def _looking_around(
    rng: np.random.Generator, time_s: NDArray[np.float64], doors_s: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Yaw beside the heading [rad]: slow drift, and glances to a side, but not on the way into a door."""
    yaw = _drift(rng, len(time_s), math.radians(4))
    at = rng.uniform(3, 8)
    while at < time_s[-1]:
        wait = float(np.min(np.where(doors_s > at - 1, doors_s - at, np.inf), initial=np.inf))
        if wait > 3.0:
            size = math.radians(rng.uniform(20, 50)) * rng.choice([-1, 1])
            yaw = yaw + size * np.exp(-(((time_s - at) / rng.uniform(0.8, 1.3)) ** 2))
        at += rng.uniform(5, 11)
    return yaw


def _drift(rng: np.random.Generator, count: int, deviation: float) -> NDArray[np.float64]:
    """(count,) slow noise of a standard deviation."""
    noise = gaussian_filter1d(rng.standard_normal(count + 400), 1.2 * KEY_RATE_HZ)[200 : 200 + count]
    return np.asarray(deviation * noise / max(float(noise.std()), 1e-12)) if count > 1 else np.zeros(count)
