"""A trip: as many walks as the frames need, cut into an episode."""

from __future__ import annotations

import numpy as np

from tacos_framework.values import Crossing, Episode, Trajectory, World
from tacos_worlds.indoor.building import Building
from tacos_worlds.indoor.walk.free_space import FreeSpace
from tacos_worlds.indoor.walk.motion import KEY_RATE_HZ, Walk, draw_walk
from tacos_worlds.indoor.walk.route import draw_route

_FIRST_THRESHOLD_ID = 1
"""Thresholds are the first objects after the background, in the order of the doors."""
_PAUSE_S = 1.0
"""Time between two walks, in which no frame is taken [s]."""


def draw_trip(
    rng: np.random.Generator,
    world: World,
    building: Building,
    *,
    frames: int,
    frame_rate_hz: float,
    speed_m_s: float,
    camera_height_m: tuple[float, float],
) -> Episode:
    """An episode of exactly `frames` frames, each walk at its own height.

    Where the frames cover less than a walk, they cover a random stretch of it around some doorway.
    """
    free = FreeSpace(building)
    times, walks, poses, key_times, crossings = [], [], [], [], []
    clock_s, left, number = 0.0, frames, 0
    while left > 0:
        route = draw_route(rng, building, free)
        walk = draw_walk(
            rng, route, speed_m_s=speed_m_s, camera_height_m=float(rng.uniform(*camera_height_m))
        )
        needed_s = (left - 1) / frame_rate_hz
        start_s = _start(rng, walk, needed_s)
        count = min(left, int((walk.duration_s - start_s) * frame_rate_hz + 1e-9) + 1)
        end_s = start_s + (count - 1) / frame_rate_hz
        kept = (walk.time_s >= start_s - 1 / KEY_RATE_HZ) & (walk.time_s <= end_s + 1 / KEY_RATE_HZ)
        shift_s = clock_s - start_s + 1 / KEY_RATE_HZ
        key_times.append(walk.time_s[kept] + shift_s)
        poses.append(walk.world_from_agent[kept])
        times.append(start_s + shift_s + np.arange(count) / frame_rate_hz)
        walks.append(np.full(count, number))
        crossings += [
            Crossing(_FIRST_THRESHOLD_ID + door, at_s + shift_s)
            for at_s, door in walk.crossings
            if start_s <= at_s <= end_s
        ]
        clock_s = float(key_times[-1][-1]) + _PAUSE_S
        left -= count
        number += 1
    return Episode(
        world=world,
        trajectory=Trajectory(np.concatenate(key_times), np.concatenate(poses)),
        time_s=np.concatenate(times),
        walk=np.concatenate(walks),
        crossings=tuple(crossings),
    )


def _start(rng: np.random.Generator, walk: Walk, needed_s: float) -> float:
    """When in a walk the frames begin: at its start, or before some doorway where they cover only a part."""
    spare_s = walk.duration_s - needed_s
    if spare_s <= 0:
        return 0.0
    if not walk.crossings:
        return float(rng.uniform(0, spare_s))
    at_s, _ = walk.crossings[int(rng.integers(len(walk.crossings)))]
    return float(np.clip(at_s - rng.uniform(0.4, 0.95) * needed_s, 0.0, spare_s))
