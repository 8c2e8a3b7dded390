"""Walkable floor of a world of any shape: found by rays, over several storeys, stairs and slopes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components, dijkstra

from tacos_plugins.lighting.occlusion import Occlusion

MOST_CELLS = 400_000
"""Larger worlds are looked at more coarsely."""
_FINEST_CELL_M = 0.1
_MOST_LAYERS = 24
_MOST_STOREYS = 6
_STEEPEST = 0.7  # least upward part of a floor's normal: 45 degrees
_BENEATH_M = 0.02  # rays go on this far below what they met
_NEIGHBOURS = ((1, 0), (0, 1), (1, 1), (1, -1))
_ROOM_M2 = 4.0  # places that could be a room, where those inside of solids are larger
_DECIMALS = 5
"""Of heights and lengths in metres: equal ways stay equal wherever the file lies, whatever float32 rounds."""


@dataclass(frozen=True)
class Agent:
    """Body of the agent that walks."""

    radius_m: float  # its middle stays this far from what it cannot step on [m]
    height_m: float  # it needs this much room above the floor [m]
    step_m: float  # the greatest step it takes up or down [m]


@dataclass(frozen=True, eq=False)
class Floor:
    """Places to stand on, and the steps between them."""

    points_m: NDArray[np.float64]  # (N, 3) places on the floor [m]
    headroom_m: NDArray[np.float64]  # (N,) free height above; infinite under the open sky [m]
    clearance_m: NDArray[np.float64]  # (N,) distance along the floor to where it ends [m]
    in_solid: NDArray[np.bool_]  # (N,) whether backs of surfaces are seen below and above, as inside a slab
    steps: csr_array  # (N, N) symmetric matrix of the lengths of single steps [m]
    cell_m: float  # distance of neighbouring places [m]

    @property
    def area_m2(self) -> float:
        return len(self.points_m) * self.cell_m**2

    def kept(self, chosen: NDArray[np.bool_] | NDArray[np.intp]) -> Floor:
        rows = np.flatnonzero(chosen) if chosen.dtype == bool else chosen
        steps = self.steps[rows][:, rows].tocsr()
        return Floor(
            self.points_m[rows],
            self.headroom_m[rows],
            self.clearance_m[rows],
            self.in_solid[rows],
            csr_array(steps),
            self.cell_m,
        )


def find_floor(occlusion: Occlusion, agent: Agent) -> Floor:
    """Every place on which an agent has room to stand, whether or not it can be reached."""
    lower, upper = occlusion.vertices_m.min(axis=0), occlusion.vertices_m.max(axis=0)
    extent = np.maximum((upper - lower).astype(np.float64)[:2], _FINEST_CELL_M)
    cell_m = max(_FINEST_CELL_M, math.sqrt(float(extent.prod()) / MOST_CELLS))
    shape = tuple(max(1, math.ceil(length / cell_m)) for length in extent)
    grid = np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), axis=-1).reshape(-1, 2)
    # A little off the middle of cells: many models have their edges there, between which rays slip through.
    ground = lower[:2] + (grid + np.array([0.4871, 0.5237])) * cell_m
    cell, height, headroom, in_solid = _standing_places(
        occlusion, ground, float(lower[2]), float(upper[2]), agent
    )
    points = np.column_stack([ground[cell], height])
    index = np.full((len(grid), _MOST_STOREYS), -1)
    first = np.concatenate([[True], cell[1:] != cell[:-1]]) if len(cell) else np.zeros(0, bool)
    storey = np.arange(len(cell)) - np.maximum.accumulate(np.where(first, np.arange(len(cell)), 0))
    low = storey < _MOST_STOREYS
    index[cell[low], storey[low]] = np.flatnonzero(low)
    steps, complete = _steps(occlusion, points, index.reshape(*shape, _MOST_STOREYS), agent)
    edge = np.flatnonzero(~complete)
    clearance = np.full(len(points), math.inf)
    if len(edge) and len(points):
        clearance = dijkstra(steps, directed=False, indices=edge, min_only=True) + cell_m / 2
    return Floor(points, headroom, clearance, in_solid, steps, cell_m)


def walkable(
    floor: Floor, agent: Agent, *, inside: bool | None, start_m: NDArray[np.float64] | None
) -> Floor:
    """The places that one walk can reach, of all that have room for the agent.

    - `inside`: true under a ceiling, False in the open; None for the ceiling where there is a good deal of
      it.
    - `start_m`: (3,) a place on the floor to be reached [m]; decides alone where given.

    Returns no place where there is none.
    """
    allowed = floor.kept(floor.clearance_m >= agent.radius_m)
    if not len(allowed.points_m):
        return allowed
    _, label = connected_components(allowed.steps, directed=False)
    if start_m is not None:
        nearest = int(np.argmin(((allowed.points_m - start_m) ** 2).sum(axis=1)))
        return allowed.kept(label == label[nearest])
    size = np.bincount(label)
    covered = np.bincount(label, np.isfinite(allowed.headroom_m)) > size / 2
    roof = np.bincount(label, _has_floor_below(allowed)) > size / 2
    under, open_air = size * covered, size * (~covered & ~roof)
    solid = np.bincount(label, allowed.in_solid) > 0.9 * size
    if (under * ~solid).max() * allowed.cell_m**2 >= _ROOM_M2:  # else a room may be a box seen from inside
        under = under * ~solid
    if inside is None:
        inside = bool(under.sum() > 0 and under.sum() >= open_air.sum() / 4)
    chosen = under if inside else open_air
    if not chosen.any():
        return allowed.kept(np.zeros(len(label), bool))
    return allowed.kept(label == int(np.argmax(chosen)))


def _standing_places(
    occlusion: Occlusion, ground_m: NDArray[np.float64], lowest_m: float, highest_m: float, agent: Agent
) -> tuple[NDArray[np.intp], NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_]]:
    """Cell, height and headroom [m] of places with room to stand, by cell and from above, and `in_solid`."""
    found: list[tuple[NDArray[Any], ...]] = []
    active = np.arange(len(ground_m))
    start = np.full(len(ground_m), highest_m + 1.0)
    above, front_above = np.full(len(ground_m), math.inf), np.zeros(len(ground_m), bool)
    for _ in range(_MOST_LAYERS):
        if not len(active):
            break
        origins = np.column_stack([ground_m[active], start[active]]).astype(np.float32)
        down = np.tile(np.array([0, 0, -1], np.float32), (len(active), 1))
        hits = occlusion.first_hits(origins, down)
        met = hits.triangle >= 0
        active, triangle = active[met], hits.triangle[met]
        height = np.round(start[active] - hits.distance_m[met], _DECIMALS)
        corners = occlusion.vertices_m[occlusion.triangles[triangle]].astype(np.float64)
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        flat = np.abs(normal[:, 2]) >= _STEEPEST * np.maximum(np.linalg.norm(normal, axis=1), 1e-12)
        room = above[active] - height
        stands = flat & (room >= agent.height_m)
        in_solid = (normal[:, 2] < 0) & front_above[active]
        found.append((active[stands], height[stands], room[stands], in_solid[stands]))
        above[active], front_above[active] = height, normal[:, 2] > 0
        start[active] = height - _BENEATH_M
        active = active[start[active] > lowest_m - 1.0]
    cell, height, room, in_solid = (np.concatenate(parts) for parts in zip(*found, strict=True))
    order = np.lexsort((-height, cell))
    return (
        cell[order].astype(np.intp),
        height[order].astype(np.float64),
        room[order].astype(np.float64),
        in_solid[order].astype(np.bool_),
    )


def _steps(
    occlusion: Occlusion, points_m: NDArray[np.float64], index: NDArray[np.intp], agent: Agent
) -> tuple[csr_array, NDArray[np.bool_]]:
    """Steps between neighbouring places, and which places have all of their eight neighbours."""
    rows, columns = (np.concatenate(pairs) for pairs in zip(*_pairs(index, points_m, agent), strict=True))
    free = np.ones(len(rows), bool)
    # Walls may be thinner than a cell, or without any thickness: bodies have to pass between places.
    for height in (agent.step_m + 0.05, agent.height_m / 2, agent.height_m - 0.1):
        raised = np.array([0.0, 0.0, height])
        open_pairs = np.flatnonzero(free)
        ends = ((points_m[side[open_pairs]] + raised).astype(np.float32) for side in (rows, columns))
        free[open_pairs] = occlusion.visible(*ends)
    rows, columns = rows[free], columns[free]
    count = len(points_m)
    complete = np.bincount(rows, minlength=count) + np.bincount(columns, minlength=count) >= 8
    length = np.round(np.linalg.norm(points_m[rows] - points_m[columns], axis=1), _DECIMALS)
    both = np.concatenate([rows, columns]), np.concatenate([columns, rows])
    return coo_array((np.tile(length, 2), both), shape=(count, count)).tocsr(), complete


def _pairs(
    index: NDArray[np.intp], points_m: NDArray[np.float64], agent: Agent
) -> Iterator[tuple[NDArray[np.intp], NDArray[np.intp]]]:
    """Places of neighbouring cells that are no more than a step apart in height."""
    nx, ny, storeys = index.shape
    for dx, dy in _NEIGHBOURS:
        one = index[: nx - dx, max(0, -dy) : ny - max(0, dy)].reshape(-1, storeys)
        other = index[dx:, max(0, dy) : ny + min(0, dy)].reshape(-1, storeys)
        for a in range(storeys):
            for b in range(storeys):
                both = (one[:, a] >= 0) & (other[:, b] >= 0)
                first, second = one[both, a], other[both, b]
                near = np.abs(points_m[first, 2] - points_m[second, 2]) <= agent.step_m
                yield first[near], second[near]


def _has_floor_below(floor: Floor) -> NDArray[np.bool_]:
    """(N,) whether another place lies in the same cell, further down."""
    cell = np.round(floor.points_m[:, :2] / (floor.cell_m / 4)).astype(np.int64)
    _, number = np.unique(cell, axis=0, return_inverse=True)
    number = number.reshape(-1)
    lowest = np.full(int(number.max(initial=-1)) + 1, math.inf)
    np.minimum.at(lowest, number, floor.points_m[:, 2])
    return np.asarray(floor.points_m[:, 2] > lowest[number] + 0.5)
