"""Flat panels, thin curved sheets and extruded outlines."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from tacos_worlds.kit.mesh import Floats, Indices, Mesh, merged, shaded


def panel(
    origin_m: ArrayLike,
    u_m: ArrayLike,
    v_m: ArrayLike,
    *,
    step_m: float = 0.5,
    uv_m: tuple[float, float] = (0.0, 0.0),
) -> Mesh:
    """A flat rectangle from `origin_m` along two vectors, facing u x v, in cells of about `step_m` [m].

    `uv_m` are the texture coordinates at the origin.
    """
    origin, u, v = (np.asarray(a, dtype=np.float64) for a in (origin_m, u_m, v_m))
    lengths = np.linalg.norm(u), np.linalg.norm(v)
    columns, rows = (max(1, round(float(length) / step_m)) for length in lengths)
    s, t = np.meshgrid(np.linspace(0, 1, columns + 1), np.linspace(0, 1, rows + 1))
    s, t = s.reshape(-1, 1), t.reshape(-1, 1)
    normal = np.cross(u, v)
    normal /= np.linalg.norm(normal)
    return Mesh(
        origin + s * u + t * v,
        np.tile(normal, (len(s), 1)),
        np.hstack([s * lengths[0], t * lengths[1]]) + np.array(uv_m),
        _grid_triangles(rows + 1, columns + 1),
    )


def sheet(points_m: Floats, *, thickness_m: float = 0.003, uv_scale: float = 1.0) -> Mesh:
    """A thin curved sheet through a (rows, columns, 3) grid, seen from both sides [m].

    It faces along (column step) x (row step); the back lies `thickness_m` behind. Texture coordinates run
    along the grid: u along columns, v along rows.
    """
    rows, columns, _ = points_m.shape
    triangles = _grid_triangles(rows, columns)
    du = np.gradient(points_m, axis=1)
    dv = np.gradient(points_m, axis=0)
    normals = np.cross(du, dv)
    length = np.linalg.norm(normals, axis=2, keepdims=True)
    normals = np.where(length > 1e-12, normals / np.maximum(length, 1e-12), [0.0, 0.0, 1.0])
    u = _arc_length(points_m, axis=1)
    v = _arc_length(points_m, axis=0)
    uv = np.stack([u, v], axis=2).reshape(-1, 2) * uv_scale
    flat, normals = points_m.reshape(-1, 3), normals.reshape(-1, 3)
    front = Mesh(flat, normals, uv, triangles)
    back = Mesh(flat - thickness_m * normals, -normals, uv, triangles[:, ::-1])
    return merged([front, back])


def extruded(outline_m: ArrayLike, height_m: float, *, z_m: float = 0.0) -> Mesh:
    """A solid with a convex outline, (N, 2) points counter-clockwise, from `z_m` up [m]."""
    outline = np.asarray(outline_m, dtype=np.float64)
    count = len(outline)
    low = np.column_stack([outline, np.full(count, z_m)])
    high = low + np.array([0, 0, height_m])
    here = np.arange(count)
    after = (here + 1) % count
    fan = np.stack([np.zeros(count - 2, dtype=np.int64), here[1:-1], here[2:]], axis=1)
    triangles = np.concatenate(
        [
            np.stack([here, after, after + count], axis=1),
            np.stack([here, after + count, here + count], axis=1),
            fan + count,
            fan[:, ::-1],
        ]
    )
    return shaded(np.concatenate([low, high]), triangles, crease_deg=30.0)


def _arc_length(points_m: Floats, *, axis: int) -> Floats:
    steps = np.linalg.norm(np.diff(points_m, axis=axis), axis=2)
    lead = np.zeros_like(np.take(steps, [0], axis=axis))
    return np.cumsum(np.concatenate([lead, steps], axis=axis), axis=axis)


def _grid_triangles(rows: int, columns: int) -> Indices:
    index = np.arange(rows * columns).reshape(rows, columns)
    a, b = index[:-1, :-1].reshape(-1), index[:-1, 1:].reshape(-1)
    c, d = index[1:, 1:].reshape(-1), index[1:, :-1].reshape(-1)
    return np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
