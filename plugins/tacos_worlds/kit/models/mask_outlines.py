"""The opaque part of a mask as convex polygons: rectangles inside, marching squares along its edge.

Source: Lorensen and Cline 1987, "Marching cubes", in two dimensions: the edge runs where the opacity,
interpolated between texels as a sampler does, is the cutoff.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def outlines(above: Floats, clamped: tuple[bool, bool]) -> Floats:
    """(P, 8, 2) polygons of one tile where (H, W) values are 0 or more, row 0 at v = 0 [tiles].

    `above`: opacity less cutoff at the texels. `clamped`: whether the texture ends at its edges along u and
    v; else it repeats.
    """
    rows, columns = above.shape
    field = np.pad(above, (_padding(clamped[1]), (0, 0)), mode="edge" if clamped[1] else "wrap")
    field = np.pad(field, ((0, 0), _padding(clamped[0])), mode="edge" if clamped[0] else "wrap")
    v = (np.arange(len(field)) + (-0.5 if clamped[1] else 0.5)) / rows
    u = (np.arange(field.shape[1]) + (-0.5 if clamped[0] else 0.5)) / columns
    inside = field >= 0
    whole = inside[:-1, :-1] & inside[1:, :-1] & inside[:-1, 1:] & inside[1:, 1:]
    some = inside[:-1, :-1] | inside[1:, :-1] | inside[:-1, 1:] | inside[1:, 1:]
    return np.concatenate([_rectangles(whole, u, v), _edges(field, some & ~whole, u, v)])


def _padding(clamped: bool) -> tuple[int, int]:
    return (1, 1) if clamped else (0, 1)


def _rectangles(whole: NDArray[np.bool_], u: Floats, v: Floats) -> Floats:
    """Runs of whole cells, joined with equal runs of the rows above."""
    done: list[tuple[int, int, int, int]] = []
    growing: dict[tuple[int, int], int] = {}
    for row in range(len(whole) + 1):
        runs: set[tuple[int, int]] = set()
        if row < len(whole):
            steps = np.diff(np.concatenate([[0], whole[row].astype(np.int8), [0]]))
            runs = set(
                zip(np.flatnonzero(steps > 0).tolist(), np.flatnonzero(steps < 0).tolist(), strict=True)
            )
        done += [(*run, growing.pop(run), row) for run in list(growing) if run not in runs]
        for run in runs:
            growing.setdefault(run, row)
    left, right, low, high = np.array(done, np.int64).reshape(-1, 4).T
    corners = [(u[left], v[low]), (u[right], v[low]), (u[right], v[high]), *[(u[left], v[high])] * 5]
    return np.stack([np.stack(corner, axis=1) for corner in corners], axis=1)


def _joined(field: Floats, cells: NDArray[np.bool_]) -> NDArray[np.int64]:
    """(N, 4) first and last row and column of cells; those along which the field is the same are one.

    Bars of fences run along an axis: as one cell they take a hundredth of the triangles.
    """
    upright = cells & (field[:-1, :-1] == field[1:, :-1]) & (field[:-1, 1:] == field[1:, 1:])
    level = cells & ~upright & (field[:-1, :-1] == field[:-1, 1:]) & (field[1:, :-1] == field[1:, 1:])
    column, low, high = _runs(upright.T)
    row, left, right = _runs(level)
    single, at = np.nonzero(cells & ~upright & ~level)
    boxes = ((low, high, column, column + 1), (row, row + 1, left, right), (single, single + 1, at, at + 1))
    return np.concatenate([np.column_stack(box) for box in boxes])


def _runs(there: NDArray[np.bool_]) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp]]:
    """Rows, first places and ends of what is there without a gap along a row."""
    steps = np.diff(np.pad(there, ((0, 0), (1, 1))).astype(np.int8), axis=1)
    (row, first), (_, end) = np.nonzero(steps > 0), np.nonzero(steps < 0)
    return row, first, end


def _edges(field: Floats, cells: NDArray[np.bool_], u: Floats, v: Floats) -> Floats:
    """Inside of cells along the edge: their corners, and where the field is zero between them."""
    box = _joined(field, cells)
    around = [(0, 2), (0, 3), (1, 3), (1, 2)]
    values = np.stack([field[box[:, r], box[:, c]] for r, c in around], axis=1)
    places = np.stack([np.stack([u[box[:, c]], v[box[:, r]]], axis=1) for r, c in around], axis=1)
    after, places_after = np.roll(values, -1, axis=1), np.roll(places, -1, axis=1)
    crosses = (values >= 0) != (after >= 0)
    along = values / np.where(crosses, values - after, 1.0)
    points = np.stack([places, places + along[..., None] * (places_after - places)], axis=2).reshape(-1, 8, 2)
    valid = np.stack([values >= 0, crosses], axis=2).reshape(-1, 8)
    order = np.argsort(~valid, axis=1, kind="stable")
    last = np.maximum(valid.sum(axis=1) - 1, 0)[:, None]
    order = np.take_along_axis(order, np.minimum(np.arange(8)[None], last), axis=1)
    return np.take_along_axis(points, order[..., None], axis=1)
