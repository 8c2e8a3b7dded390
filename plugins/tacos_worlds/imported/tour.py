"""Ways over the floor: tours of all of it, or along waypoints, and the obstacles stepped on."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components, dijkstra

from tacos_plugins.lighting.occlusion import Occlusion
from tacos_worlds.imported.floor import Floor

STEP_M = 0.05
"""Distance between points of a way [m]."""
_COMFORT_M = 0.8
"""Beyond this distance from things a way is not penalised [m]."""
_SMOOTHING_M = 0.25
_AREA_PER_STOP_M2 = 8.0
_FEWEST_STOPS, _MOST_STOPS = 3, 16
_REACH_M = 0.3
_ROUNDING = 1e-3


@dataclass(frozen=True, eq=False)
class Way:
    """A line over the floor."""

    points_m: NDArray[np.float64]  # (N, 3) points on the floor, about `STEP_M` apart [m]
    steps_on: tuple[tuple[int, int], ...]
    """For each obstacle stepped on, in order: (index of the point, id of the object)."""


def within(rng: np.random.Generator, floor: Floor, size_m: tuple[float, float] | None) -> Floor:
    """A connected piece of the floor no larger than `size_m` along x and y [m]; all of it where that fits."""
    if size_m is None or np.all(np.ptp(floor.points_m[:, :2], axis=0) <= size_m):
        return floor
    half = np.array(size_m) / 2
    middle = floor.points_m[int(rng.integers(len(floor.points_m)))]
    # Moved inwards, so that a piece at the border is as large as one in the middle.
    low, high = floor.points_m[:, :2].min(axis=0) + half, floor.points_m[:, :2].max(axis=0) - half
    centre = np.clip(middle[:2], np.minimum(low, high), np.maximum(low, high))
    piece = floor.kept(np.all(np.abs(floor.points_m[:, :2] - centre) <= half, axis=1))
    _, label = connected_components(piece.steps, directed=False)
    return piece.kept(label == label[int(np.argmin(((piece.points_m - middle) ** 2).sum(axis=1)))])


def draw_tour(rng: np.random.Generator, floor: Floor) -> NDArray[np.float64]:
    """(N, 3) a way past stops spread over all of a floor, each next one the nearest that is left [m]."""
    stops = math.ceil(np.clip(floor.area_m2 / _AREA_PER_STOP_M2, _FEWEST_STOPS, _MOST_STOPS))
    graph = _penalised(floor)
    roomy = np.flatnonzero(floor.clearance_m >= np.quantile(floor.clearance_m, 0.5))
    here = int(rng.choice(roomy))
    chosen, distance = [here], np.full(len(floor.points_m), math.inf)
    for _ in range(stops):
        distance = np.minimum(distance, _lengths(graph, chosen[-1]))
        weight = np.where(np.isfinite(distance[roomy]), distance[roomy], 0) ** 4
        if not weight.sum() > 0:
            break
        chosen.append(int(rng.choice(roomy, p=weight / weight.sum())))  # far from all stops so far
    left, line = set(chosen[1:]) - {here}, [np.array([here])]
    while left:
        lengths, before = dijkstra(graph, directed=False, indices=np.array([here]), return_predecessors=True)
        there = min(left, key=lambda stop: (lengths[0, stop], stop))
        line.append(_traced(before[0], here, there)[1:])
        left -= set(line[-1].tolist()) | {there}
        here = there
    return _even(floor.points_m[np.concatenate(line)], _SMOOTHING_M)


def along_waypoints(floor: Floor, waypoints_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N, 3) a way over the floor from one of (M, 3) waypoints to the next [m].

    Raises ValueError where a waypoint lies off the floor.
    """
    at = []
    for number, point in enumerate(waypoints_m, start=1):
        away = np.linalg.norm(floor.points_m[:, :2] - point[:2], axis=1)
        away = np.hypot(away, np.where(np.isnan(point[2]), 0, floor.points_m[:, 2] - point[2]))
        at.append(int(np.argmin(away)))
        if away[at[-1]] > _REACH_M + floor.cell_m:
            raise ValueError(f"waypoint {number} is {away[at[-1]]:.2f} m from where the agent can walk")
    graph, line = _penalised(floor), [np.array(at[:1])]
    for here, there in itertools.pairwise(at):
        _, before = dijkstra(graph, directed=False, indices=np.array([here]), return_predecessors=True)
        line.append(_traced(before[0], here, there)[1:])
    return _even(floor.points_m[np.concatenate(line)], _SMOOTHING_M)


def stepped_on(
    occlusion: Occlusion,
    object_of_triangle: NDArray[np.int32],
    points_m: NDArray[np.float64],
    obstacles: Sequence[int],
    *,
    above_m: float,
    reach_m: float,
) -> Way:
    """A line with the obstacles on it: what lies underfoot, seen from above it.

    `obstacles`: ids of objects that count. `above_m`, `reach_m`: from how far above the line one looks, and
    how far down from there [m].
    """
    above = (points_m + np.array([0, 0, above_m])).astype(np.float32)
    hits = occlusion.first_hits(above, np.tile(np.array([0, 0, -1], np.float32), (len(above), 1)))
    near = (hits.triangle >= 0) & (hits.distance_m <= reach_m)
    underfoot = np.where(near, object_of_triangle[np.maximum(hits.triangle, 0)], 0)
    counts = np.isin(underfoot, np.asarray(obstacles, np.int32))
    begins = counts & np.concatenate([[True], underfoot[1:] != underfoot[:-1]])
    return Way(points_m, tuple((int(k), int(underfoot[k])) for k in np.flatnonzero(begins)))


def _penalised(floor: Floor) -> csr_array:
    lack = np.clip(1 - floor.clearance_m / _COMFORT_M, 0, 1)
    steps = coo_array(floor.steps)
    cost = steps.data * (1 + 1.5 * (lack[steps.row] ** 2 + lack[steps.col] ** 2))
    return coo_array((cost, (steps.row, steps.col)), shape=steps.shape).tocsr()


def _lengths(graph: csr_array, start: int) -> NDArray[np.float64]:
    return np.asarray(dijkstra(graph, directed=False, indices=np.array([start])))[0]


def _traced(before: NDArray[np.int32], start: int, end: int) -> NDArray[np.intp]:
    places = [end]
    while places[-1] != start:
        places.append(int(before[places[-1]]))
    return np.array(places[::-1])


def _even(points_m: NDArray[np.float64], smoothing_m: float) -> NDArray[np.float64]:
    """A line in steps of equal length, with corners rounded."""
    length = np.linalg.norm(np.diff(points_m, axis=0), axis=1)
    points_m = points_m[np.concatenate([[True], length > 1e-9])]
    run = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points_m, axis=0), axis=1))])
    at = np.linspace(0.0, run[-1], max(2, math.ceil(run[-1] / STEP_M - _ROUNDING) + 1))
    line = np.column_stack([np.interp(at, run, points_m[:, axis]) for axis in range(3)])
    smooth = gaussian_filter1d(line, smoothing_m / STEP_M, axis=0, mode="nearest")
    smooth[0], smooth[-1] = line[0], line[-1]
    return np.asarray(smooth)
