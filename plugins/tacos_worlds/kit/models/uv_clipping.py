"""Triangles cut along lines in their texture: polygons clipped by triangles, all pairs at once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tacos_worlds.kit.models.model import Surface

_LEAST_SHARE = 1e-9
"""Of a triangle's area; less is rounding [1]."""

Floats = NDArray[np.float64]


def cut(surface: Surface, owner: NDArray[np.int64], polygons: Floats) -> Surface:
    """Part of a surface within convex polygons of its texture.

    - `surface`: with `uv`.
    - `owner`: (N,) the triangle that each polygon cuts.
    - `polygons`: (N, K, 2) counter-clockwise corners, the last repeated where there are fewer [tiles].
    """
    assert surface.uv is not None
    corners = surface.uv[surface.triangles]
    area = _cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    pieces, row = clipped(polygons, _turned_left(corners)[owner])
    owner = owner[row]
    weights = _weights(corners[owner], area[owner], pieces)
    fans = np.concatenate([weights[:, [0, i, i + 1]] for i in range(1, pieces.shape[1] - 1)])
    owner = np.tile(owner, pieces.shape[1] - 2)
    share = _cross(fans[:, 1, 1:] - fans[:, 0, 1:], fans[:, 2, 1:] - fans[:, 0, 1:])
    fans, owner = fans[np.abs(share) > _LEAST_SHARE], owner[np.abs(share) > _LEAST_SHARE]
    backwards = area[owner] < 0
    fans[backwards] = fans[backwards][:, ::-1]
    used = surface.triangles[owner]

    def mixed(values: Floats | None) -> Floats | None:
        return (
            None
            if values is None
            else np.einsum("nkc,ncj->nkj", fans, values[used]).reshape(-1, values.shape[1])
        )

    vertices = mixed(surface.vertices)
    assert vertices is not None
    return replace(
        surface,
        vertices=vertices,
        triangles=np.arange(len(vertices)).reshape(-1, 3),
        normals=mixed(surface.normals),
        uv=mixed(surface.uv),
        colours=mixed(surface.colours),
    )


def clipped(polygons: Floats, triangles: Floats) -> tuple[Floats, NDArray[np.intp]]:
    """Convex polygons within triangles, pair by pair (Sutherland and Hodgman 1974).

    - `polygons`: (N, K, 2).
    - `triangles`: (N, 3, 2), counter-clockwise.

    Returns:
    - `pieces`: (M, K + 3, 2) of the pairs that meet, the last corner repeated.
    - `row`: (M,) which pair each is of.
    """
    row = np.arange(len(polygons))
    for edge in range(3):
        begin, end = triangles[row, edge][:, None], triangles[row, (edge + 1) % 3][:, None]
        side = _cross(end - begin, polygons - begin)
        following, side_after = np.roll(polygons, -1, axis=1), np.roll(side, -1, axis=1)
        inside, crosses = side >= 0, (side >= 0) != (side_after >= 0)
        along = side / np.where(crosses, side - side_after, 1.0)
        met = polygons + along[..., None] * (following - polygons)
        points = np.stack([polygons, met], axis=2).reshape(len(row), -1, 2)
        valid = np.stack([inside, crosses], axis=2).reshape(len(row), -1)
        kept = valid.any(axis=1)
        points, valid, row = points[kept], valid[kept], row[kept]
        order = np.argsort(~valid, axis=1, kind="stable")[:, : polygons.shape[1] + 1]
        last = np.maximum(valid.sum(axis=1) - 1, 0)[:, None]
        order = np.take_along_axis(order, np.minimum(np.arange(order.shape[1])[None], last), axis=1)
        polygons = np.take_along_axis(points, order[..., None], axis=1)
    return polygons, row


def _turned_left(corners: Floats) -> Floats:
    area = _cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.where((area < 0)[:, None, None], corners[:, ::-1], corners)


def _weights(corners: Floats, area: Floats, points: Floats) -> Floats:
    """(N, K, 3) weights of the corners of (N, 3, 2) triangles at (N, K, 2) points."""
    first = corners[:, :1]
    second = _cross(points - first, (corners[:, 2] - corners[:, 0])[:, None]) / area[:, None]
    third = _cross((corners[:, 1] - corners[:, 0])[:, None], points - first) / area[:, None]
    return np.stack([1 - second - third, second, third], axis=2)


def _cross(first: Floats, second: Floats) -> Floats:
    return np.asarray(first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0])
