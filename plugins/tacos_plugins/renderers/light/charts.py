"""Flat surfaces and their places in the light map.

Light on large flat surfaces changes between their few vertices (shadows do), so it is kept in texels; light
on small or curved ones is kept per vertex.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_plugins.renderers.light.flatten import FlatMesh

LEAST_WIDTH_M = 0.10
LEAST_LENGTH_M = 0.25
"""Flat surfaces smaller than this are lit per vertex [m]."""

LEAST_FILL = 0.2
"""Flat surfaces that cover less of their rectangle are lit per vertex [1]."""

MOST_TEXELS = 1 << 20
"""Larger worlds get a coarser light map."""

_PADDING_TEXELS = 1
_INSET_M = 0.01


@dataclass(frozen=True, eq=False)
class Charts:
    """Rectangles on flat surfaces, and where their texels lie in the light map.

    A chart's first and last texel centres lie on the rectangle's edges.
    """

    of_triangle: NDArray[np.int32]
    """(T,) int32 chart of each triangle; -1 for those lit per vertex."""
    origin_m: NDArray[np.float64]
    """(C, 3) float64 corner of the rectangle [m]."""
    axes: NDArray[np.float64]
    """(C, 2, 3) float64 unit vectors along its edges [1]."""
    normal: NDArray[np.float64]
    """(C, 3) float64 [1]."""
    step_m: NDArray[np.float64]
    """(C, 2) distance of texels along each axis [m]."""
    size: NDArray[np.int32]
    """(C, 2) int32 number of texels (columns, rows)."""
    place: NDArray[np.int32]
    """(C, 2) int32 first texel (column, row) in the light map."""
    map_size: tuple[int, int]
    """Width and height of the light map [texels]."""

    def __len__(self) -> int:
        return len(self.size)

    def texels(self) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.int32]]:
        """Chart, column and row inside the chart of every texel, chart by chart: three (N,) int32."""
        counts = self.size[:, 0] * self.size[:, 1]
        chart = np.repeat(np.arange(len(self), dtype=np.int32), counts)
        within = np.arange(len(chart), dtype=np.int32) - np.repeat(np.cumsum(counts) - counts, counts)
        row, column = np.divmod(within, self.size[chart, 0])
        return chart, column.astype(np.int32), row.astype(np.int32)

    def points(
        self, chart: NDArray[np.int32], column: NDArray[np.int32], row: NDArray[np.int32]
    ) -> NDArray[np.float64]:
        """(N, 3) where the light of texels is computed, drawn in from the rectangle's edges [m].

        At the very edge a neighbouring surface begins, and rays would start inside it.
        """
        step, last = self.step_m[chart], (self.size[chart] - 1).astype(np.float64)
        inset = np.minimum(0.1, _INSET_M / np.maximum(step, 1e-9))
        along = np.clip(np.column_stack([column, row]), inset, np.maximum(last - inset, inset)) * step
        return self.origin_m[chart] + np.einsum("ni,nij->nj", along, self.axes[chart])

    def coordinates(self, chart: NDArray[np.int32], point_m: NDArray[np.floating]) -> NDArray[np.float32]:
        """(N, 2) light map coordinates of points on charts, 0..1 [1]."""
        along = np.einsum("nij,nj->ni", self.axes[chart], point_m - self.origin_m[chart])
        texel = self.place[chart] + along / self.step_m[chart] + 0.5
        return (texel / np.asarray(self.map_size)).astype(np.float32)


def find_charts(mesh: FlatMesh, texel_m: float) -> Charts:
    """Find the flat surfaces of a mesh worth a light map, and place them in it.

    `texel_m`: greatest distance of texels where parts have a light detail of 1, kept to where the map does
    not grow beyond `MOST_TEXELS` [m].
    """
    corners = mesh.corners_m.astype(np.float64)
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    twice_area = np.linalg.norm(cross, axis=1)
    normal = cross / np.maximum(twice_area, 1e-12)[:, None]
    offset = np.einsum("ij,ij->i", normal, corners.mean(axis=1))
    plane = np.column_stack([mesh.part, np.round(normal * 500), np.round(offset * 500)]).astype(np.int64)
    order, starts = _alike(plane)
    leader, group = order[starts], np.empty(len(order), np.intp)
    group[order] = np.repeat(np.arange(len(starts)), np.diff(starts, append=len(order)))

    group_normal = normal[leader]
    axes = _axes_in_plane(group_normal)
    along = np.einsum("tij,tcj->tci", axes[group], corners)  # (T, corner, axis)
    lower = np.minimum.reduceat(along.min(axis=1)[order], starts)
    upper = np.maximum.reduceat(along.max(axis=1)[order], starts)
    extent = upper - lower
    area = np.bincount(group, weights=twice_area / 2, minlength=len(leader))
    worthy = (
        (extent.min(axis=1) >= LEAST_WIDTH_M)
        & (extent.max(axis=1) >= LEAST_LENGTH_M)
        & (area >= LEAST_FILL * extent[:, 0] * extent[:, 1])
    )

    chosen = np.flatnonzero(worthy)
    number = np.full(len(leader), -1, dtype=np.int32)
    number[chosen] = np.arange(len(chosen))
    wanted = extent[chosen] * mesh.light_detail[mesh.part[leader[chosen]], None]
    texel_m = max(texel_m, float(np.sqrt(wanted.prod(axis=1).sum() / MOST_TEXELS)))
    size = np.maximum(np.ceil(wanted / texel_m).astype(np.int32) + 1, 2)
    place, map_size = pack_shelves(size + 2 * _PADDING_TEXELS)
    height = np.einsum("ij,ij->i", group_normal, corners[leader].mean(axis=1))[chosen]
    chosen_axes, chosen_normal = axes[chosen], group_normal[chosen]
    return Charts(
        of_triangle=number[group],
        origin_m=np.einsum("ci,cij->cj", lower[chosen], chosen_axes) + height[:, None] * chosen_normal,
        axes=chosen_axes,
        normal=chosen_normal,
        step_m=extent[chosen] / np.maximum(size - 1, 1),
        size=size,
        place=place + _PADDING_TEXELS,
        map_size=map_size,
    )


def _alike(rows: NDArray[np.int64]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """(N,) order in which equal rows stand together, the first of them first, and where each kind starts.

    Kinds rise as `np.unique` has them, which is slow at rows.
    """
    order = np.lexsort(rows.T[::-1])
    ordered = rows[order]
    changes = np.ones(len(rows), dtype=bool)
    changes[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    return order, np.flatnonzero(changes)


def _axes_in_plane(normal: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N, 2, 3) two unit vectors in each plane; horizontal and upright for walls."""
    upright = np.abs(normal[:, 2:3]) < 0.9
    guide = np.where(upright, [0.0, 0.0, 1.0], [0.0, 1.0, 0.0])
    first = np.cross(guide, normal)
    first /= np.maximum(np.linalg.norm(first, axis=1, keepdims=True), 1e-12)
    return np.stack([first, np.cross(normal, first)], axis=1)


def pack_shelves(size: NDArray[np.int32]) -> tuple[NDArray[np.int32], tuple[int, int]]:
    """Place rectangles in rows of falling height.

    `size`: (C, 2) int32 widths and heights [texels].

    Returns:

    - `place`: (C, 2) int32 first column and row of each.
    - `map_size`: width and height that hold them all.

    >>> place, map_size = pack_shelves(np.array([[2, 1], [3, 2]], np.int32))
    >>> place.tolist(), map_size
    ([[0, 2], [0, 0]], (3, 3))
    """
    if len(size) == 0:
        return np.zeros((0, 2), np.int32), (1, 1)
    total = int((size[:, 0].astype(np.int64) * size[:, 1]).sum())
    width = int(max(size[:, 0].max(), np.ceil(np.sqrt(total))))
    place = np.zeros_like(size)
    x = y = shelf = 0
    for index in np.lexsort((-size[:, 0], -size[:, 1])):
        w, h = int(size[index, 0]), int(size[index, 1])
        if x + w > width:
            x, y, shelf = 0, y + shelf, 0
        place[index] = x, y
        x, shelf = x + w, max(shelf, h)
    return place, (width, y + shelf)
