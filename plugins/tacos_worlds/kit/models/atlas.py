"""Colours of vertices as a texture, since materials carry colour in textures alone.

Two triangles share a square of four by four texels. The squares lie in the atlas along a Z-curve, in the
order in which triangles lie along one in space: coarser levels of the texture then average over neighbours.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tacos_framework.camera import srgb_from_linear
from tacos_worlds.kit.models.patch import Patch

_CELL_PX = 4
_CORNERS_PX = {0: ((0.5, 0.5), (2.5, 0.5), (0.5, 2.5)), 1: ((3.5, 3.5), (1.5, 3.5), (3.5, 1.5))}
"""Where the corners of the lower and of the upper triangle lie in a cell [px]."""
MOST_PX = 4096


def painted(patches: Sequence[Patch]) -> tuple[list[Patch], NDArray[np.uint8]]:
    """Patches with colours at their vertices as patches with texture coordinates, and their (A, A, 3) atlas.

    Raises ValueError where the triangles are more than the largest atlas holds.
    """
    counts = [len(patch.triangles) for patch in patches]
    edge_cells = 1 << math.ceil(math.log2(max(1.0, math.sqrt((sum(counts) + 1) // 2))))
    if edge_cells * _CELL_PX > MOST_PX:
        raise ValueError(f"{sum(counts)} coloured triangles need more than {MOST_PX} px of texture")
    corners = np.concatenate([patch.vertices_m[patch.triangles] for patch in patches])
    colours = np.concatenate([_of_corners(patch) for patch in patches])
    place = np.empty(sum(counts), np.int64)
    place[np.argsort(_z_order(corners.mean(axis=1)), kind="stable")] = np.arange(sum(counts))
    cell = np.column_stack(_unfold(place // 2))
    upper = place % 2
    inside = np.array([_CORNERS_PX[0], _CORNERS_PX[1]])[upper]
    edge_px = edge_cells * _CELL_PX
    uv = (cell[:, None, :] * _CELL_PX + inside) / edge_px
    atlas = np.zeros((edge_px, edge_px, 3))
    _fill(atlas, cell, upper, colours)
    ends = np.cumsum(counts)
    textured = [
        _unshared(patch, uv[end - count : end])
        for patch, count, end in zip(patches, counts, ends, strict=True)
    ]
    return textured, np.rint(srgb_from_linear(atlas) * 255).astype(np.uint8)


def _of_corners(patch: Patch) -> NDArray[np.float64]:
    assert patch.colours is not None
    return patch.colours[patch.triangles]


def _fill(
    atlas: NDArray[np.float64],
    cell: NDArray[np.int64],
    upper: NDArray[np.int64],
    colours: NDArray[np.float64],
) -> None:
    """Paint every texel of a cell from the triangle it belongs to, extended beyond its edges."""
    for which in (0, 1):
        own = np.flatnonzero(upper == which)
        a, b, c = np.array(_CORNERS_PX[which])
        basis = np.linalg.inv(np.column_stack([b - a, c - a]))
        for row in range(_CELL_PX):
            for column in range(_CELL_PX):
                # The diagonal belongs to the lower triangle; an odd last one has its cell to itself.
                if (row + column > _CELL_PX - 1) != bool(which):
                    continue
                s, t = basis @ (np.array([column + 0.5, row + 0.5]) - a)
                mix = np.array([1 - s - t, s, t])
                value = np.clip(np.einsum("c,ncj->nj", mix, colours[own]), 0, 1)
                atlas[cell[own, 1] * _CELL_PX + row, cell[own, 0] * _CELL_PX + column] = value


def _unshared(patch: Patch, uv: NDArray[np.float64]) -> Patch:
    """Every triangle with corners of its own."""
    corner = patch.triangles.reshape(-1)
    return replace(
        patch,
        vertices_m=patch.vertices_m[corner],
        triangles=np.arange(len(corner)).reshape(-1, 3),
        normals=None if patch.normals is None else patch.normals[corner],
        uv=uv.reshape(-1, 2),
        colours=None,
    )


def _z_order(points_m: NDArray[np.float64]) -> NDArray[np.int64]:
    """(N,) place of points along a Z-curve through space (Morton order)."""
    lower, extent = points_m.min(axis=0), max(float(np.ptp(points_m, axis=0).max()), 1e-9)
    steps = np.clip((points_m - lower) / extent * 1023, 0, 1023).astype(np.int64)
    code = np.zeros(len(steps), np.int64)
    for bit in range(10):
        for axis in range(3):
            code |= ((steps[:, axis] >> bit) & 1) << (3 * bit + axis)
    return code


def _unfold(place: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Column and row of places along a Z-curve through a square."""
    column, row = np.zeros_like(place), np.zeros_like(place)
    for bit in range(16):
        column |= ((place >> (2 * bit)) & 1) << bit
        row |= ((place >> (2 * bit + 1)) & 1) << bit
    return column, row
