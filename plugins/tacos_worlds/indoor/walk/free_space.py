"""Free space of the agent, on a grid."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import dijkstra

from tacos_worlds.indoor.building import Building
from tacos_worlds.kit.rectangle import Rect

CELL_M = 0.1
CLEARANCE_M = 0.35
"""The middle of the agent stays this far from walls and furniture [m]."""
_COMFORT_M = 0.7
"""Beyond this distance from things, a path is not penalised [m]."""


class FreeSpace:
    """Distance to the nearest obstacle, and cheapest paths that keep away from them."""

    def __init__(self, building: Building) -> None:
        plan = building.plan
        shape = tuple(math.ceil(length / CELL_M) for length in plan.size_m)
        x = (np.arange(shape[0]) + 0.5) * CELL_M
        y = (np.arange(shape[1]) + 0.5) * CELL_M

        def cells(rect: Rect, grow_m: float = 0.0) -> NDArray[np.bool_]:
            r = rect.grown(grow_m)
            return np.asarray(((x > r.x0) & (x < r.x1))[:, None] & ((y > r.y0) & (y < r.y1))[None, :])

        free = np.zeros(shape, bool)
        for room in range(len(plan.cells)):
            free |= cells(plan.clear(room))
        for door in plan.doors:
            free |= cells(door.zone(0.2))
        for rect in [m.footprint for m in building.furniture if m.blocks] + list(building.leaves):
            free &= ~cells(rect, CELL_M / 2)
        padded = np.pad(free, 1)
        self.clearance_m: NDArray[np.float64] = ndimage.distance_transform_edt(padded)[1:-1, 1:-1] * CELL_M
        label, _ = ndimage.label(self.clearance_m >= CLEARANCE_M, structure=np.ones((3, 3)))
        self._allowed = label == np.bincount(label[label > 0]).argmax()  # pockets cannot be reached
        self._index = np.full(shape, -1)
        self._index[self._allowed] = np.arange(int(self._allowed.sum()))
        self._cells = np.argwhere(self._allowed)
        self._graph = self._build_graph()

    def _build_graph(self) -> csr_array:
        penalty = (
            1 + 3 * np.clip(1 - (self.clearance_m - CLEARANCE_M) / (_COMFORT_M - CLEARANCE_M), 0, 1) ** 2
        )
        rows, columns, costs = [], [], []
        nx, ny = self._allowed.shape
        for dx, dy in ((1, 0), (0, 1), (1, 1), (1, -1)):
            a = np.s_[max(0, -dx) : nx - max(0, dx), max(0, -dy) : ny - max(0, dy)]
            b = np.s_[max(0, dx) : nx + min(0, dx), max(0, dy) : ny + min(0, dy)]
            both = self._allowed[a] & self._allowed[b]
            rows.append(self._index[a][both])
            columns.append(self._index[b][both])
            costs.append(math.hypot(dx, dy) * (penalty[a][both] + penalty[b][both]) / 2)
        count = len(self._cells)
        return coo_array(
            (np.concatenate(costs), (np.concatenate(rows), np.concatenate(columns))), shape=(count, count)
        ).tocsr()

    def nearest(self, point_m: NDArray[np.float64]) -> int:
        return int(np.argmin((((self._cells + 0.5) * CELL_M - point_m) ** 2).sum(axis=1)))

    def path(self, start_m: NDArray[np.float64], end_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N, 2) points from start to end [m]. Raises ValueError when there is no way."""
        start, end = self.nearest(start_m), self.nearest(end_m)
        _, before = dijkstra(self._graph, directed=False, indices=np.array([start]), return_predecessors=True)
        cells = [end]
        while cells[-1] != start:
            previous = int(before[0, cells[-1]])
            if previous < 0:
                raise ValueError(f"no way from {start_m} to {end_m}")
            cells.append(previous)
        middle = (self._cells[cells[::-1]] + 0.5) * CELL_M
        return np.vstack([start_m, middle[1:-1], end_m])

    def random_point(
        self,
        rng: np.random.Generator,
        low_m: NDArray[np.float64],
        high_m: NDArray[np.float64],
        here_m: NDArray[np.float64],
        heading: NDArray[np.float64],
    ) -> NDArray[np.float64]:
        """A point with room around it inside a rectangle, rather far from `here_m` and rather ahead.

        `heading` is the (2,) direction in which one comes to `here_m`, or zero where there is none.
        """
        centres = (self._cells + 0.5) * CELL_M
        inside = np.all((centres > low_m) & (centres < high_m), axis=1)
        cells = self._cells[inside]
        room = self.clearance_m[cells[:, 0], cells[:, 1]]
        onward = centres[inside] - here_m
        distance = np.linalg.norm(onward, axis=1)
        ahead = (onward @ heading) / np.maximum(distance, 1e-9)
        weight = np.clip(room - CLEARANCE_M, 0.02, 0.5) * distance * (1.05 + ahead) ** 2
        return np.asarray(centres[inside][rng.choice(len(cells), p=weight / weight.sum())])
