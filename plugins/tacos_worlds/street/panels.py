"""Flat surfaces with texture coordinates of one's choice."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from tacos_worlds.kit.mesh import Mesh

Span = tuple[float, float]


def panel(
    origin_m: ArrayLike,
    u_m: ArrayLike,
    v_m: ArrayLike,
    *,
    u: Span | None = None,
    v: Span | None = None,
    step_m: float = math.inf,
) -> Mesh:
    """A rectangle from `origin_m` along two vectors, facing u x v.

    `u`, `v`: texture coordinates at the two ends of each edge; metres along it from 0 where left out.
    `step_m`: greatest edge of its cells [m].
    """
    origin, along_u, along_v = (np.asarray(a, dtype=np.float64) for a in (origin_m, u_m, v_m))
    lengths = float(np.linalg.norm(along_u)), float(np.linalg.norm(along_v))
    columns, rows = (max(1, math.ceil(length / step_m - 1e-9)) for length in lengths)
    grid = np.meshgrid(np.linspace(0, 1, columns + 1), np.linspace(0, 1, rows + 1))
    s, t = grid[0].ravel(), grid[1].ravel()
    (u0, u1), (v0, v1) = u or (0.0, lengths[0]), v or (0.0, lengths[1])
    normal = np.cross(along_u, along_v)
    index = np.arange((rows + 1) * (columns + 1)).reshape(rows + 1, columns + 1)
    a, b = index[:-1, :-1].ravel(), index[:-1, 1:].ravel()
    c, d = index[1:, 1:].ravel(), index[1:, :-1].ravel()
    return Mesh(
        vertices_m=origin + s[:, None] * along_u + t[:, None] * along_v,
        normals=np.tile(normal / np.linalg.norm(normal), (len(s), 1)),
        uv_m=np.column_stack([u0 + (u1 - u0) * s, v0 + (v1 - v0) * t]),
        triangles=np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])]),
    )


def ground(x: Span, y: Span, z_m: float, *, step_m: float = math.inf) -> Mesh:
    """A level rectangle that faces up; its texture coordinates are x and y, so that neighbours agree [m]."""
    return panel((x[0], y[0], z_m), (x[1] - x[0], 0, 0), (0, y[1] - y[0], 0), u=x, v=y, step_m=step_m)


def fan(outline_m: ArrayLike, z_m: float, centre_m: ArrayLike | None = None) -> Mesh:
    """A level polygon that faces up, from its (N, 2) corners, counter-clockwise seen from above [m].

    It must be star-shaped about `centre_m`, the mean of its corners where left out.
    """
    outline = np.asarray(outline_m, dtype=np.float64)
    middle = outline.mean(axis=0) if centre_m is None else np.asarray(centre_m, dtype=np.float64)
    points = np.vstack([outline, middle])
    here = np.arange(len(outline))
    return Mesh(
        vertices_m=np.column_stack([points, np.full(len(points), z_m)]),
        normals=np.tile([0.0, 0.0, 1.0], (len(points), 1)),
        uv_m=points.copy(),
        triangles=np.column_stack([here, (here + 1) % len(outline), np.full(len(outline), len(outline))]),
    )


def upright(outline_m: ArrayLike, z_m: Span, *, closed: bool = False) -> Mesh:
    """Walls along (N, 2) points from one height to another, facing right of the way along them [m]."""
    points = np.asarray(outline_m, dtype=np.float64)
    if closed:
        points = np.vstack([points, points[:1]])
    start, end = points[:-1], points[1:]
    run = end - start
    length = np.linalg.norm(run, axis=1)
    normal = np.column_stack([run[:, 1], -run[:, 0], np.zeros(len(run))]) / length[:, None]
    before = np.concatenate([[0.0], np.cumsum(length)[:-1]])
    low, high = z_m
    corners = [(start, low), (end, low), (end, high), (start, high)]
    vertices = np.stack([np.column_stack([p, np.full(len(p), z)]) for p, z in corners], axis=1)
    across = np.stack([before, before + length, before + length, before], axis=1)
    up = np.tile([low, low, high, high], (len(run), 1))
    first = 4 * np.arange(len(run))
    return Mesh(
        vertices_m=vertices.reshape(-1, 3),
        normals=np.repeat(normal, 4, axis=0),
        uv_m=np.stack([across, up], axis=2).reshape(-1, 2),
        triangles=np.concatenate(
            [np.column_stack([first, first + 1, first + 2]), np.column_stack([first, first + 2, first + 3])]
        ),
    )
