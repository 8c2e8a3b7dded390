"""A car's way through the town: which turns it takes, along which line, how fast."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from tacos_framework import Trajectory
from tacos_worlds.street.city import CARRIAGEWAY_M, CORNER_M, LANE_M, PARKING_M, Town

KEY_RATE_HZ = 20.0
"""Poses per second of a trajectory [Hz]."""
LATERAL_M_S2 = 2.2
"""Acceleration to the side in bends, at most [m/s2]."""
FORWARD_M_S2 = 1.6
"""Acceleration along the way, at most [m/s2]."""
BRAKING_M_S2 = 2.2
RIGHT_RADIUS_M = CORNER_M + PARKING_M + LANE_M / 2
"""Radius of turns to the right: concentric with the kerb [m]."""
LEFT_RADIUS_M = 9.0
_STEP_M = 0.25
_SMOOTHING_M = 0.8
"""Turning in takes about this long [m]."""
_STRAIGHT_ON = 0.5

_HEADINGS = ((1, 0), (0, 1), (-1, 0), (0, -1))


@dataclass(frozen=True, eq=False)
class Way:
    """A line through the town, in steps of equal length."""

    points_m: NDArray[np.float64]  # (N, 2) [m]
    heading_rad: NDArray[np.float64]  # (N,) continuous [rad]


def draw_way(rng: np.random.Generator, town: Town, length_m: float) -> Way:
    """A random way of at least `length_m` on the right-hand lanes between the inner crossings, no U-turns."""
    lines = (town.street_x_m, town.street_y_m)
    counts = len(lines[0]), len(lines[1])
    heading = int(rng.integers(4))
    along, across = heading % 2, 1 - heading % 2
    at = [0, 0]
    at[across] = int(rng.integers(counts[across]))
    at[along] = int(rng.integers(1, counts[along]))  # a crossing with an inner street behind it
    if heading >= 2:
        at[along] -= 1
    crossing = _crossing(lines, at)
    back = _crossing(lines, [a - b for a, b in zip(at, _HEADINGS[heading], strict=True)])
    share = rng.uniform(0.1, 0.6)
    points = [_in_lane(crossing + share * (back - crossing), heading)]
    travelled = 0.0
    while travelled < length_m:
        following = _turn(rng, at, heading, counts)
        crossing = _crossing(lines, at)
        for point in _through(crossing, heading, following):
            travelled += float(np.linalg.norm(point - points[-1]))
            points.append(point)
        heading = following
        at = [a + b for a, b in zip(at, _HEADINGS[heading], strict=True)]
    points.append(_in_lane(_crossing(lines, at) - CARRIAGEWAY_M * np.array(_HEADINGS[heading]), heading))
    return _smoothed(np.array(points))


def _crossing(lines: tuple[tuple[float, ...], tuple[float, ...]], at: list[int]) -> NDArray[np.float64]:
    return np.array([lines[0][at[0]], lines[1][at[1]]])


def _turn(rng: np.random.Generator, at: list[int], heading: int, counts: tuple[int, int]) -> int:
    """The heading to leave a crossing with, such that another crossing follows."""
    options, weights = [], []
    for turn, weight in ((0, _STRAIGHT_ON), (1, (1 - _STRAIGHT_ON) / 2), (3, (1 - _STRAIGHT_ON) / 2)):
        following = (heading + turn) % 4
        there = [a + b for a, b in zip(at, _HEADINGS[following], strict=True)]
        if all(0 <= place < count for place, count in zip(there, counts, strict=True)):
            options.append(following)
            weights.append(weight)
    return int(rng.choice(options, p=np.array(weights) / sum(weights)))


def _in_lane(middle_m: NDArray[np.float64], heading: int) -> NDArray[np.float64]:
    """A point of the middle line moved into the right-hand lane."""
    x, y = _HEADINGS[heading]
    return middle_m + LANE_M / 2 * np.array([y, -x])


def _through(crossing_m: NDArray[np.float64], heading: int, following: int) -> NDArray[np.float64]:
    if following == heading:
        return _in_lane(crossing_m, heading)[None]
    ahead, after = np.array(_HEADINGS[heading]), np.array(_HEADINGS[following])
    meet = _in_lane(crossing_m, heading) + _in_lane(crossing_m, following) - crossing_m
    left = (following - heading) % 4 == 1
    radius = LEFT_RADIUS_M if left else RIGHT_RADIUS_M
    centre = meet + radius * (after - ahead)
    angle = np.linspace(0, math.pi / 2, 17)[:, None]
    return np.asarray(centre - radius * (np.cos(angle) * after - np.sin(angle) * ahead))


def _smoothed(corners_m: NDArray[np.float64]) -> Way:
    """Equal steps along a polygon, with bends that begin and end gently."""
    run = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(corners_m, axis=0), axis=1))])
    at = np.arange(0.0, run[-1], _STEP_M)
    points = np.column_stack([np.interp(at, run, corners_m[:, axis]) for axis in (0, 1)])
    points = gaussian_filter1d(points, _SMOOTHING_M / _STEP_M, axis=0, mode="nearest")
    inside = slice(round(4 * _SMOOTHING_M / _STEP_M), -round(4 * _SMOOTHING_M / _STEP_M))
    step = np.gradient(points, axis=0)
    heading = np.unwrap(np.arctan2(step[:, 1], step[:, 0]))
    return Way(points[inside], heading[inside])


def speeds(way: Way, most_m_s: float) -> NDArray[np.float64]:
    """(N,) speed along a way, slow in bends, with gentle acceleration and braking [m/s]."""
    curvature = np.abs(np.gradient(way.heading_rad)) / _STEP_M
    speed = np.minimum(most_m_s, np.sqrt(LATERAL_M_S2 / np.maximum(curvature, 1e-6)))
    squared = speed**2
    for i in range(1, len(squared)):
        squared[i] = min(squared[i], squared[i - 1] + 2 * FORWARD_M_S2 * _STEP_M)
    for i in range(len(squared) - 2, -1, -1):
        squared[i] = min(squared[i], squared[i + 1] + 2 * BRAKING_M_S2 * _STEP_M)
    return np.sqrt(squared)


def drive(way: Way, most_m_s: float, camera_height_m: float) -> Trajectory:
    """The way over time; the eye is at the camera's height above the road."""
    pace = 1 / speeds(way, most_m_s)
    reached_s = np.concatenate([[0.0], np.cumsum((pace[1:] + pace[:-1]) / 2 * _STEP_M)])
    time_s = np.arange(0.0, reached_s[-1], 1 / KEY_RATE_HZ)
    poses = np.tile(np.eye(4), (len(time_s), 1, 1))
    heading = np.interp(time_s, reached_s, way.heading_rad)
    cos, sin = np.cos(heading), np.sin(heading)
    poses[:, 0, 0], poses[:, 0, 1], poses[:, 1, 0], poses[:, 1, 1] = cos, -sin, sin, cos
    for axis in (0, 1):
        poses[:, axis, 3] = np.interp(time_s, reached_s, way.points_m[:, axis])
    poses[:, 2, 3] = camera_height_m
    return Trajectory(time_s, poses)
