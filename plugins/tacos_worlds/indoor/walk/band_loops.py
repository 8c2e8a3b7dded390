"""A path that rounds off like a stretched band, compiled; imported late, as numba takes a while.

Coordinates come as arrays of their own: slices of arrays take seconds to compile.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tacos_plugins.compiled.loops import compiled

Floats = NDArray[np.float64]


@compiled
def relax(
    x_m: Floats,
    y_m: Floats,
    moves: NDArray[np.bool_],
    reaches: NDArray[np.int64],
    clearance_m: Floats,
    cell_m: float,
    least_m: float,
) -> None:
    """Pull every point half-way to the middle of its neighbours, where that comes too near to nothing.

    - `x_m`, `y_m`: (N,) coordinates of the path, which are changed [m].
    - `moves`: (N,) the points that may move; never the first and last.
    - `reaches`: for each step, how many points away the neighbours are; those next to a point always count as
      well. Steps that reach over half the path and more are left out.
    - `clearance_m`: (X, Y) distance to the nearest obstacle at the middle of each cell [m].
    - `cell_m`: edge of a cell [m].
    - `least_m`: a point stays where it is rather than come nearer to an obstacle than this [m].
    """
    count = len(x_m)
    pulled_x, pulled_y = np.empty(count), np.empty(count)
    for step in range(len(reaches)):
        if count <= 2 * reaches[step]:
            continue
        _pull(x_m, reaches[step], pulled_x)
        _pull(y_m, reaches[step], pulled_y)
        for at in range(1, count - 1):
            row, column = pulled_x[at] / cell_m - 0.5, pulled_y[at] / cell_m - 0.5
            if moves[at] and _between_cells(clearance_m, row, column) >= least_m:
                x_m[at], y_m[at] = pulled_x[at], pulled_y[at]


@compiled
def _pull(coordinate: Floats, reach: int, pulled: Floats) -> None:
    """Targets that all points but the first and last are pulled to, along one axis."""
    count = len(coordinate)
    for at in range(1, count - 1):
        target = coordinate[at]
        if reach <= at < count - reach:
            target = (coordinate[at - reach] + coordinate[at + reach]) / 2
        target = 0.5 * target + 0.25 * (coordinate[at - 1] + coordinate[at + 1])
        pulled[at] = coordinate[at] + 0.5 * (target - coordinate[at])


@compiled
def _between_cells(grid: Floats, row: float, column: float) -> float:
    """A grid between its nearest cells, in the order of `ndimage.map_coordinates`; beyond, as at its edge."""
    last_row, last_column = grid.shape[0] - 1, grid.shape[1] - 1
    row, column = min(max(row, 0.0), float(last_row)), min(max(column, 0.0), float(last_column))
    low, left = int(row), int(column)
    high, right = min(low + 1, last_row), min(left + 1, last_column)
    up, across = row - low, column - left
    value: float = grid[low, left] * (1.0 - up) * (1.0 - across)
    value += grid[low, right] * (1.0 - up) * across
    value += grid[high, left] * up * (1.0 - across)
    value += grid[high, right] * up * across
    return value
