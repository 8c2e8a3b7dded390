"""Triangles at one place that face opposite ways: the two sides of one sheet."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

_SAME_PLACE_M = 1e-4
_LEVER_M = 0.1
"""Planes are those of one sheet where places this far from each other in it are [m]."""
_BESIDE = 1e-3
"""Of its size, how far beside a triangle a place may lie by rounding [1]."""
_MOST_PAIRS = 2_000_000
"""Planes with more pairs of triangles that face each other hold more than a sheet."""
_WITHIN = np.array(
    [(1, 1, 1), (98, 1, 1), (1, 98, 1), (1, 1, 98), (49, 49, 2), (49, 2, 49), (2, 49, 49)], np.float64
)
"""Weights of corners of places within a triangle, up to their sum."""


def numbered(rows: NDArray[np.int64]) -> NDArray[np.int64]:
    """(N,) a number for each row of (N, K), equal for equal rows.

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
    """(N,) a number for each of (N, K) points, equal for those hardly apart: sides differ by rounding."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    cell = numbered(np.round((points_m - points_m.min(axis=0)) / _SAME_PLACE_M).astype(np.int64))
    one_of = np.zeros((int(cell.max()) + 1, points_m.shape[1]))
    one_of[cell] = points_m
    near = cKDTree(one_of).query_pairs(_SAME_PLACE_M, output_type="ndarray")  # a border between cells apart
    joined = coo_array((np.ones(len(near), bool), near.T), (len(one_of), len(one_of)))
    return np.asarray(connected_components(joined, directed=False)[1][cell], np.int64)


def corners_behind(
    vertices_m: NDArray[np.floating], triangles: NDArray[np.integer], other: NDArray[np.int64]
) -> NDArray[np.int64]:
    """(T, 3) for each corner of a triangle the vertex of its other side at the same place.

    Triangles without another side keep their own.

    - `vertices_m`: (V, 3) [m].
    - `triangles`: (T, 3) vertices.
    - `other`: (T,) as `other_sides` gives it.
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

    Sides that are cut into triangles otherwise are sides of one sheet too: of several triangles behind one,
    that behind its middle is given.

    A ray, or a depth buffer, cannot tell such two apart: which is seen has to follow from the side one looks
    from.

    `corners_m`: (T, 3, 3) corners of triangles [m].

    Returns: (T,) int64 indices of triangles.
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
    same = np.where(flat, -1, first[number[count:]])
    lonely = np.flatnonzero((same < 0) & ~flat)
    same[lonely] = _behind_otherwise_cut(corners_m[lonely].astype(np.float64), lonely)
    return same


def _behind_otherwise_cut(corners_m: NDArray[np.float64], names: NDArray[np.int64]) -> NDArray[np.int64]:
    """The name of the triangle behind the middle of each that others cover, and that covers others."""
    count = len(corners_m)
    behind = np.full(count, -1, np.int64)
    cross = np.cross(corners_m[:, 1] - corners_m[:, 0], corners_m[:, 2] - corners_m[:, 0])
    normal = cross / np.maximum(np.linalg.norm(cross, axis=1, keepdims=True), 1e-300)
    middle = corners_m.reshape(-1, 3).mean(axis=0) if count else np.zeros(3)
    along = np.einsum("ij,ij->i", normal, corners_m.mean(axis=1) - middle)
    plane = np.column_stack([normal * _LEVER_M, along])
    number = _places(np.concatenate([plane, -plane])) if count else np.zeros(0, np.int64)
    ahead, away = number[:count], number[count:]
    shared = np.intersect1d(ahead, away)
    for one, other in zip(_members(ahead, shared), _members(away, shared), strict=True):
        if len(one) * len(other) > _MOST_PAIRS:
            continue
        kept = np.delete(np.arange(3), int(np.argmax(np.abs(normal[one[0]]))))
        found, back = (
            _covering(corners_m[a][..., kept], corners_m[b][..., kept])
            for a, b in ((one, other), (other, one))
        )
        covered = (found >= 0) & (back[found] >= 0)
        behind[one[covered]] = names[other[found[covered]]]
    return behind


def _members(number: NDArray[np.int64], chosen: NDArray[np.int64]) -> Iterator[NDArray[np.int64]]:
    """The indices that have each of the chosen numbers."""
    order = np.argsort(number, kind="stable")
    ordered = number[order]
    for first, last in zip(
        np.searchsorted(ordered, chosen), np.searchsorted(ordered, chosen, side="right"), strict=True
    ):
        yield order[first:last]


def _covering(corners: NDArray[np.float64], others: NDArray[np.float64]) -> NDArray[np.int64]:
    """For (T, 3, 2) triangles the one of (U, 3, 2) others at its middle; -1 where some of it is bare."""
    triangle, other = _near_pairs(corners, others)
    places = np.einsum("pc,ncj->npj", _WITHIN / _WITHIN.sum(axis=1, keepdims=True), corners[triangle])
    origin, u, v = others[other, :1], others[other, 1] - others[other, 0], others[other, 2] - others[other, 0]
    doubled = (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])[:, None]
    x, y = np.moveaxis(places - origin, 2, 0)
    second = (x * v[:, 1:] - y * v[:, :1]) / doubled
    third = (u[:, :1] * y - u[:, 1:] * x) / doubled
    inside = np.minimum(np.minimum(second, third), 1 - second - third) > -_BESIDE
    covered = np.zeros((len(corners), len(_WITHIN)), bool)
    pair, place = np.nonzero(inside)
    covered[triangle[pair], place] = True
    at_middle = np.full(len(corners), -1, np.int64)
    over_middle = np.flatnonzero(inside[:, 0])[::-1]  # of several the first, which is written last
    at_middle[triangle[over_middle]] = other[over_middle]
    return np.where(covered.all(axis=1), at_middle, -1)


def _near_pairs(
    corners: NDArray[np.float64], others: NDArray[np.float64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Indices of (T, 3, 2) triangles and (U, 3, 2) others whose boxes meet: most of a plane lie apart."""
    low, high = others.min(axis=1), others.max(axis=1)
    beside = 3 * _BESIDE * (high - low)
    meet = (corners.min(axis=1)[:, None] <= high + beside) & (corners.max(axis=1)[:, None] >= low - beside)
    triangle, other = np.nonzero(meet.all(axis=2))
    return triangle, other
