"""Polygons as triangles, and corners as vertices: what OBJ and PLY have in common."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from tacos_worlds.kit.models.model import Surface

_MOST_CORNERS = 2000
"""Larger polygons that are not convex are cut into a fan, as their ears would take the square of this."""
_FLAT = 1e-9


def surface_of(
    path: tuple[str, ...],
    skin: int,
    vertices: NDArray[np.float64],
    sizes: NDArray[np.int64],
    corners: NDArray[np.int64],
    *,
    uv: NDArray[np.float64] | None = None,
    normals: NDArray[np.float64] | None = None,
    colours: NDArray[np.float64] | None = None,
) -> Surface:
    """Polygons as a surface whose vertices differ where texture coordinates or normals do.

    - `sizes`: (F,) corners of each polygon.
    - `corners`: (C, 3) of each corner the vertex and the rows of `uv` and `normals`.
    - `colours`: (V, 3) of the vertices, linear [1].
    """
    key, wide = np.zeros(len(corners), np.int64), corners.max(axis=0, initial=0) + 1
    for column in range(3):
        key = key * wide[column] + corners[:, column]
    _, first, place = np.unique(key, return_index=True, return_inverse=True)
    used = corners[first]
    triangles = triangulated(vertices[corners[:, 0]], sizes)
    return Surface(
        path=path,
        vertices=vertices[used[:, 0]],
        triangles=place.reshape(-1)[triangles],
        skin=skin,
        normals=None if normals is None else normals[used[:, 2]],
        uv=None if uv is None else uv[used[:, 1]],
        colours=None if colours is None else colours[used[:, 0]],
    )


def triangulated(points: NDArray[np.float64], sizes: NDArray[np.int64]) -> NDArray[np.int64]:
    """(T, 3) corners of triangles that cover polygons, convex or not; those of two corners are left out.

    - `points`: (C, 3) corners of all polygons, one polygon after another.
    - `sizes`: (F,) corners of each.

    Source: Meisters 1975, "Polygons have ears".
    """
    start = np.cumsum(sizes) - sizes
    parts, faces = [np.zeros((0, 3), np.int64)], [np.zeros(0, np.int64)]
    for size in np.unique(sizes[sizes >= 3]):
        face = np.flatnonzero(sizes == size)
        corner = start[face, None] + np.arange(size)
        convex = np.ones(len(face), bool) if size == 3 else _convex(points[corner])
        fan = np.column_stack([np.zeros(size - 2, int), np.arange(1, size - 1), np.arange(2, size)])
        parts.append(corner[convex][:, fan].reshape(-1, 3))
        faces.append(np.repeat(face[convex], size - 2))
        for index in np.flatnonzero(~convex):
            parts.append(corner[index][np.array([*_ears(points[corner[index]])])])
            faces.append(np.full(size - 2, face[index]))
    order = np.argsort(np.concatenate(faces), kind="stable")
    return np.concatenate(parts)[order].astype(np.int64)


def _normals(polygons: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N, 3) twice the vector areas of (N, n, 3) polygons."""
    away = polygons - polygons[:, :1]
    return np.asarray(np.cross(away, np.roll(away, -1, axis=1)).sum(axis=1))


def _convex(polygons: NDArray[np.float64]) -> NDArray[np.bool_]:
    """(N,) whether no corner of (N, n, 3) polygons turns the other way."""
    edge = np.roll(polygons, -1, axis=1) - polygons
    normal = _normals(polygons)
    turn = np.einsum("nij,nj->ni", np.cross(np.roll(edge, 1, axis=1), edge), normal)
    size = np.einsum("nj,nj->n", normal, normal)
    return np.asarray((turn >= -_FLAT * size[:, None]).all(axis=1) | (polygons.shape[1] > _MOST_CORNERS))


def _ears(polygon: NDArray[np.float64]) -> Iterator[tuple[int, int, int]]:
    """Triangles of one polygon, cut off where a corner has no other one within."""
    normal = _normals(polygon[None])[0]
    drop = int(np.argmax(np.abs(normal)))
    flat = (polygon - polygon[0])[:, [axis for axis in range(3) if axis != drop]]
    flat *= [1, np.sign(normal[drop]) * (-1 if drop == 1 else 1)]
    least = _FLAT * float(np.abs(normal[drop]))
    left = list(range(len(flat)))
    while len(left) > 3:
        point = flat[left]
        before, after = np.roll(point, 1, axis=0), np.roll(point, -1, axis=0)
        turn = _cross(point - before, after - point)
        ear = next(
            (int(i) for i in np.flatnonzero(turn > least) if _empty(before[i], point[i], after[i], point)),
            int(np.argmin(np.abs(turn))),
        )
        yield left[ear - 1], left[ear], left[(ear + 1) % len(left)]
        del left[ear]
    yield left[0], left[1], left[2]


def _empty(
    a: NDArray[np.float64], b: NDArray[np.float64], c: NDArray[np.float64], points: NDArray[np.float64]
) -> bool:
    """True if no point lies in a triangle, but for those at its corners."""
    inside = np.minimum(
        np.minimum(_cross(b - a, points - a), _cross(c - b, points - b)), _cross(a - c, points - c)
    )
    at_corner = np.any([(points == corner).all(axis=1) for corner in (a, b, c)], axis=0)
    return not ((inside >= 0) & ~at_corner).any()


def _cross(u: NDArray[np.float64], v: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0])
