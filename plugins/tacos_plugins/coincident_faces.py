"""Triangles at one place that face opposite ways: the two sides of one sheet."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_SAME_PLACE_M = 1e-4


def numbered(rows: NDArray[np.int64]) -> NDArray[np.int64]:
    """(N,) a number for each row of (N, K), equal for equal rows.

    Examples
    --------
    >>> numbered(np.array([[3, 1], [0, 2], [3, 1]])).tolist()
    [0, 1, 0]
    """
    order = np.lexsort(rows.T)
    ordered = rows[order]
    starts = np.concatenate([[False], (ordered[1:] != ordered[:-1]).any(axis=1)])[: len(rows)]
    number = np.empty(len(rows), np.int64)
    number[order] = np.cumsum(starts)
    return number


def _places(points_m: NDArray[np.float64]) -> NDArray[np.int64]:
    """(N,) a number for each point, equal for those hardly apart: sides of a sheet differ by rounding."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    cell = numbered(np.round((points_m - points_m.min(axis=0)) / _SAME_PLACE_M).astype(np.int64))
    one_of = np.zeros((int(cell.max()) + 1, 3))
    one_of[cell] = points_m
    near = cKDTree(one_of).query_pairs(_SAME_PLACE_M, output_type="ndarray")  # a border between cells apart
    joined = coo_array((np.ones(len(near), bool), near.T), (len(one_of), len(one_of)))
    return np.asarray(connected_components(joined, directed=False)[1][cell], np.int64)


def corners_behind(
    vertices_m: NDArray[np.floating], triangles: NDArray[np.integer], other: NDArray[np.int64]
) -> NDArray[np.int64]:
    """(T, 3) for each corner of a triangle the vertex of its other side at the same place.

    Triangles without another side keep their own.

    Parameters
    ----------
    vertices_m
        (V, 3) [m].
    triangles
        (T, 3) vertices.
    other
        (T,) as `other_sides` gives it.
    """
    corners = triangles.astype(np.int64)
    two_sided = np.flatnonzero(other >= 0)
    behind = corners[other[two_sided]]
    away = vertices_m[corners[two_sided]][:, :, None] - vertices_m[behind][:, None]
    nearest = np.argmin((away.astype(np.float64) ** 2).sum(axis=3), axis=2)
    corners[two_sided] = np.take_along_axis(behind, nearest, axis=1)
    return corners


def other_sides(corners_m: NDArray[np.floating]) -> NDArray[np.int64]:
    """The triangle at the place of each that faces the other way; -1 where there is none.

    A ray, or a depth buffer, cannot tell such two apart: which is seen has to follow from the side one looks
    from.

    Parameters
    ----------
    corners_m
        (T, 3, 3) corners of triangles [m].

    Returns
    -------
    NDArray
        (T,) int64 indices of triangles.
    """
    count = len(corners_m)
    if not count:
        return np.zeros(0, np.int64)
    points = corners_m.reshape(-1, 3).astype(np.float64)
    corner = _places(points).reshape(-1, 3)
    lowest = np.argmin(corner, axis=1)
    ahead = np.take_along_axis(corner, (lowest[:, None] + np.arange(3)) % 3, axis=1)
    number = numbered(np.concatenate([ahead, ahead[:, [0, 2, 1]]]))
    first = np.full(int(number.max()) + 1, -1, np.int64)
    first[number[:count][::-1]] = np.arange(count)[::-1]
    flat = (corner == np.roll(corner, 1, axis=1)).any(axis=1)
    return np.where(flat, -1, first[number[count:]])
