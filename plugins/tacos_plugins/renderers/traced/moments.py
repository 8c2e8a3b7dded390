"""The moments of an exposure, and where things that move are at one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Episode, MeshPart, World


def moments_s(middle_s: float, exposure_s: float, count: int) -> NDArray[np.float64]:
    """(count,) moments spread evenly over an exposure [s].

    >>> moments_s(1.0, 0.4, 2).tolist()
    [0.9, 1.1]
    """
    return middle_s + ((np.arange(count) + 0.5) / count - 0.5) * exposure_s


def world_at(episode: Episode, time_s: float) -> World:
    """The world of an episode with what moves where it is at a time; the world itself where nothing does.

    What moves keeps the light it has where it rests.
    """
    if not episode.movers:
        return episode.world
    moved = {mover.object_id: mover.trajectory.at(np.array([time_s]))[0] for mover in episode.movers}
    parts = tuple(
        part if (pose := moved.get(part.object_id)) is None else _moved(part, pose)
        for part in episode.world.parts
    )
    return replace(episode.world, key=f"{episode.world.key} at {time_s!r} s", parts=parts)


def _moved(part: MeshPart, pose: NDArray[np.float64]) -> MeshPart:
    turn = pose[:3, :3]
    return replace(
        part,
        vertices_m=(part.vertices_m @ turn.T + pose[:3, 3]).astype(np.float32),
        normals=(part.normals @ turn.T).astype(np.float32),
    )
