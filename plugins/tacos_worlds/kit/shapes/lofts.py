"""Solids swept through rings: turned legs, pots, tubs, tubes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from tacos_worlds.kit.mesh import Floats, Indices, Mesh, shaded


def loft(rings: Sequence[Floats], *, capped: bool = True, crease_deg: float = 40.0) -> Mesh:
    """A surface through rings of equally many points, counter-clockwise seen from the last ring's side.

    With `capped` the first and last rings are closed by a fan to their mean, which makes it a solid.
    """
    points = np.concatenate(rings)
    if capped:
        points = np.concatenate([points, [rings[0].mean(axis=0), rings[-1].mean(axis=0)]])
    return shaded(points, _triangles(len(rings[0]), len(rings), capped), crease_deg=crease_deg)


@lru_cache(maxsize=256)
def _triangles(count: int, levels: int, capped: bool) -> Indices:
    """(T, 3) of a loft through `levels` rings of `count` points, with two more points where it is capped."""
    here = np.arange(count)
    after = (here + 1) % count
    triangles = []
    for low in range(0, (levels - 1) * count, count):
        high = low + count
        triangles.append(np.stack([low + here, low + after, high + after], axis=1))
        triangles.append(np.stack([low + here, high + after, high + here], axis=1))
    if capped:
        last, bottom, top = (levels - 1) * count, levels * count, levels * count + 1
        triangles.append(np.stack([after, here, np.full(count, bottom)], axis=1))
        triangles.append(np.stack([last + here, last + after, np.full(count, top)], axis=1))
    return np.concatenate(triangles)


def _cross(first: Floats, second: Floats) -> Floats:
    """(3,) cross product of two vectors; numpy's own is made for many."""
    (a, b, c), (x, y, z) = first.tolist(), second.tolist()
    return np.array([b * z - c * y, c * x - a * z, a * y - b * x])


def disc_stack(
    profile_m: ArrayLike, at_m: tuple[float, float, float] = (0.0, 0.0, 0.0), *, sides: int = 12
) -> Mesh:
    """A solid of revolution about z through (radius, height) pairs, from the bottom outside upwards [m].

    A profile that turns back down inside makes a vessel.
    """
    turn = np.arange(sides) * 2 * math.pi / sides
    radius_m, height_m = np.asarray(profile_m, dtype=np.float64).T[..., None]
    height_m = np.broadcast_to(height_m, (len(height_m), sides))
    rings = np.stack([radius_m * np.cos(turn), radius_m * np.sin(turn), height_m], axis=2) + np.array(at_m)
    return loft(list(rings))


def superellipse(
    half_x_m: float, half_y_m: float, z_m: float, *, power: float = 3.0, sides: int = 20
) -> Floats:
    """(sides, 3) ring between an ellipse (power 2) and a rectangle (large power) [m]."""
    turn = (np.arange(sides) + 0.5) * 2 * math.pi / sides
    cos, sin = np.cos(turn), np.sin(turn)
    x = np.sign(cos) * np.abs(cos) ** (2 / power) * half_x_m
    y = np.sign(sin) * np.abs(sin) ** (2 / power) * half_y_m
    return np.column_stack([x, y, np.full(sides, z_m)])


def tube(
    path_m: ArrayLike, radius_m: float | Sequence[float], *, sides: int = 8, crease_deg: float = 50.0
) -> Mesh:
    """A round tube along (N, 3) points, with flat ends; one radius, or one per point [m]."""
    path = np.asarray(path_m, dtype=np.float64)
    radii = np.broadcast_to(np.asarray(radius_m, dtype=np.float64), len(path))
    tangents = np.gradient(path, axis=0)
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    across = np.cross(tangents[0], [0.0, 0.0, 1.0] if abs(tangents[0][2]) < 0.9 else [1.0, 0.0, 0.0])
    turn = np.arange(sides) * 2 * math.pi / sides
    rings = []
    for point, tangent, radius in zip(path, tangents, radii, strict=True):
        across = across - (across @ tangent) * tangent  # carried along without twist
        across /= np.linalg.norm(across)
        up = _cross(tangent, across)
        rings.append(point + radius * (np.cos(turn)[:, None] * across + np.sin(turn)[:, None] * up))
    return loft(rings, crease_deg=crease_deg)
