"""Trips along recorded poses."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Crossing, Episode, Trajectory, World
from tacos_worlds.imported.formats.poses import AGENT_FROM_OPTICAL, doubt_of_time, read_poses
from tacos_worlds.imported.tour import stepped_on
from tacos_worlds.imported.walkable_place import Place

_LEAST_UPRIGHT = 0.5
"""The vertical part of an agent's upward axis: less is tilted by over 60 degrees [1]."""
_DEEPEST_M = 4.0
"""An eye is no higher above what the agent steps on [m]."""


def read_recorded(
    file: Path, turn: NDArray[np.float64], origin_m: NDArray[np.float64], *, of_camera: bool
) -> tuple[Trajectory, list[str]]:
    """Poses of the agent from a file, in metres with z up, and what is doubtful of them.

    - `turn`: (3, 3) from its axes and unit to metres with z up.
    - `origin_m`: (3,) where the origin of the world lies, in metres with z up [m].
    - `of_camera`: true if its poses are of an optical frame; else of an agent.
    """
    found = read_poses(file)
    rotation = turn / np.cbrt(np.linalg.det(turn))
    poses = np.tile(np.eye(4), (len(found.poses), 1, 1))
    own = found.poses[:, :3, :3]
    poses[:, :3, :3] = rotation @ (own @ AGENT_FROM_OPTICAL[:3, :3].T if of_camera else own)
    poses[:, :3, 3] = found.poses[:, :3, 3] @ turn.T - origin_m
    doubts = [f"{file.name}: {doubt}" for doubt in found.doubts]
    if found.unit != ("ns" if found.form == "euroc" else "s"):
        layout = {"tum": "TUM", "euroc": "EuRoC"}[found.form]
        doubts.append(f"{file.name}: stamps are read as {found.unit}, in the layout of {layout}")
    if doubt := doubt_of_time(replace(found, poses=poses)):
        doubts.append(f"{file.name}: {doubt}")
    if np.median(poses[:, 2, 2]) < _LEAST_UPRIGHT:
        doubts.append(
            f"{file.name}: the camera lies on its side or looks straight up or down on most of the way: "
            "check path_axes, path_of, and whether quaternions begin or end with w"
        )
    return Trajectory(found.time_s, poses), doubts


def recorded_episode(
    rng: np.random.Generator, world: World, place: Place, frames: int, frame_rate_hz: float
) -> Episode:
    """Frames at a steady rate along a recorded path, from a random start where they do not cover all of
    it."""
    assert place.recorded is not None
    trajectory = place.recorded
    duration_s = float(trajectory.time_s[-1])
    count = min(frames, int(duration_s * frame_rate_hz + 1e-9) + 1)
    spare_s = duration_s - (count - 1) / frame_rate_hz
    time_s = rng.uniform(0, max(spare_s, 0.0)) + np.arange(count) / frame_rate_hz
    crossings = tuple(
        Crossing(thing, at_s) for at_s, thing in _steps(place) if time_s[0] <= at_s <= time_s[-1]
    )
    return Episode(world, trajectory, time_s, np.zeros(count, np.int32), crossings)


def _steps(place: Place) -> list[tuple[float, int]]:
    """Moments at which an obstacle lies below the agent: (time [s], object)."""
    assert place.recorded is not None
    trajectory = place.recorded
    time_s = np.arange(0.0, float(trajectory.time_s[-1]), 0.05)
    if not len(time_s) or not place.obstacles:
        return []
    eyes = trajectory.at(time_s)[:, :3, 3]
    underfoot = place.occlusion, place.object_of_triangle
    way = stepped_on(*underfoot, eyes, place.obstacles, above_m=0.0, reach_m=_DEEPEST_M)
    return [(float(time_s[point]), thing) for point, thing in way.steps_on]
