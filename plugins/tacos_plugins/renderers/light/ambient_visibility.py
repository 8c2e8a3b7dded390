"""Ambient visibility of surface points near other surfaces: contact shading of indirect light."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tacos_plugins.renderers.light.rays import RayTracer

REACH_M = 0.5
"""Distance up to which things darken the indirect light of a point [m]."""

_RAYS = 24
_BURIED_SHARE = 0.3  # of rays that meet backs: such a point lies inside something
_BLOCK = 1 << 14


def near_ambient_visibility(
    point_m: NDArray[np.float32], normal: NDArray[np.float32], wanted: NDArray[np.bool_], tracer: RayTracer
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """Ambient visibility of the hemisphere above points, and whether they lie inside something.

    `point_m`, `normal`: (N, 3) [m, 1]. `wanted`: (N,) points to look at; the others come out open and not
    buried.

    Returns:

    - `ambient_visibility`: (N,) float32, 1 where nothing is within `REACH_M` [1].
    - `buried`: (N,) bool.
    """
    ambient_visibility = np.ones(len(point_m), np.float32)
    buried = np.zeros(len(point_m), dtype=bool)
    pattern = cosine_hemisphere(_RAYS)
    chosen = np.flatnonzero(wanted)
    for start in range(0, len(chosen), _BLOCK):
        who = chosen[start : start + _BLOCK]
        directions = around(normal[who], pattern).reshape(-1, 3) * np.float32(REACH_M)
        hits = tracer.first_hits(np.repeat(point_m[who], _RAYS, axis=0), directions, 1.0)
        nearness = np.where(hits.triangle >= 0, (1 - hits.distance) ** 2, 0).reshape(-1, _RAYS)
        ambient_visibility[who] = 1 - nearness.mean(axis=1)
        buried[who] = hits.from_behind.reshape(-1, _RAYS).mean(axis=1) > _BURIED_SHARE
    return ambient_visibility, buried


def cosine_hemisphere(count: int) -> NDArray[np.float32]:
    """(count, 3) directions around +z, as dense as the cosine to it (a Fibonacci spiral, lifted) [1]."""
    squared = (np.arange(count) + 0.5) / count
    turn = np.pi * (3 - np.sqrt(5)) * np.arange(count)
    ring = np.sqrt(squared)
    return np.column_stack([ring * np.cos(turn), ring * np.sin(turn), np.sqrt(1 - squared)]).astype(
        np.float32
    )


def around(axis: NDArray[np.float32], pattern: NDArray[np.float32]) -> NDArray[np.float32]:
    """(N, S, 3) a pattern of (S, 3) directions turned from +z to each of (N, 3) axes [1]."""
    guide = np.where(np.abs(axis[:, 2:3]) < 0.9, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]]).astype(np.float32)
    first = np.cross(guide, axis)
    first /= np.maximum(np.linalg.norm(first, axis=1, keepdims=True), np.float32(1e-9))
    frame = np.stack([first, np.cross(axis, first), axis], axis=1)  # (N, 3 axes, 3)
    return np.einsum("sk,nkj->nsj", pattern, frame, optimize=True)
