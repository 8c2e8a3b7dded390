"""Order of rooms on a walk, and the path on the floor through them."""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from tacos_worlds.indoor.building import Building
from tacos_worlds.indoor.floor_plan import FloorPlan
from tacos_worlds.indoor.walk.band_loops import relax
from tacos_worlds.indoor.walk.free_space import CELL_M, CLEARANCE_M, FreeSpace
from tacos_worlds.kit.walk.route import STEP_M, Route

_STRAIGHT_M = 0.45
"""The path runs straight through the middle of a door this far to either side of it [m]."""
_FIXED_M = 0.18
"""Only this much of it is kept from being rounded off [m]."""
_REACHES = (16, 10, 6)
"""Points a path is bent over, from coarse to fine smoothing [1]."""
_SMOOTHING_STEPS = 150
_ROUNDING_M = 0.2
"""Where the band leans on something it has a kink, rounded at last over this length [m]."""


def draw_tour(rng: np.random.Generator, plan: FloorPlan) -> tuple[int, list[int]]:
    """A random first room, and the doors to pass so that every room is visited; nearest rooms first."""
    room = int(rng.integers(len(plan.cells)))
    start, doors, seen = room, [], {room}
    while len(seen) < len(plan.cells):
        steps = _doors_to_unseen(rng, plan, room, seen)
        for door in steps:
            a, b = plan.doors[door].rooms
            room = b if room == a else a
            doors.append(door)
        seen.add(room)
    return start, doors


def _doors_to_unseen(rng: np.random.Generator, plan: FloorPlan, room: int, seen: set[int]) -> list[int]:
    queue: deque[tuple[int, list[int]]] = deque([(room, [])])
    reached = {room}
    while queue:
        here, doors = queue.popleft()
        if here not in seen:
            return doors
        for index in rng.permutation(len(plan.doors)).tolist():
            a, b = plan.doors[index].rooms
            there = b if here == a else a
            if here in (a, b) and there not in reached:
                reached.add(there)
                queue.append((there, [*doors, index]))
    raise ValueError("the floor plan has a room that no door leads to")


def draw_route(rng: np.random.Generator, building: Building, free: FreeSpace) -> Route:
    """A smooth path through all rooms, with a detour inside each room on the first visit."""
    plan = building.plan
    room, doors = draw_tour(rng, plan)
    way = _Way(rng, plan, free, room)
    if not doors:
        way.wander(room, 3)
    seen = {room}
    for index in doors:
        room = way.through(index, room)
        if room not in seen:
            seen.add(room)
            way.wander(room, 2)  # a loop rather than a dead end
    points = _smoothed(np.concatenate(way.legs), np.concatenate(way.fixed), free)
    even = _resampled(points)
    # Points of `even` lie evenly over the length of `points`.
    share = _arc_m(points) / _arc_m(points)[-1]
    return Route(even, tuple((round(share[at] * (len(even) - 1)), door) for at, door in way.crossed))


class _Way:
    """A path being laid, leg by leg.

    - `legs`: (N, 2) points of each leg [m].
    - `fixed`: (N,) for each leg, the points that smoothing must not move.
    - `crossed`: (index of the point in a doorway, index of the door).
    """

    def __init__(self, rng: np.random.Generator, plan: FloorPlan, free: FreeSpace, room: int) -> None:
        self._rng, self._plan, self._free = rng, plan, free
        self._heading = np.zeros(2)
        self._here = np.array(plan.clear(room).centre)
        self._here = self._somewhere(room)
        self.legs: list[NDArray[np.float64]] = [self._here[None]]
        self.fixed: list[NDArray[np.bool_]] = [np.zeros(1, bool)]
        self.crossed: list[tuple[int, int]] = []

    def through(self, index: int, room: int) -> int:
        """Walk out of a room through the middle of a door; the room behind it."""
        door = self._plan.doors[index]
        onward = door.direction if door.rooms[0] == room else -door.direction
        before, after = door.position_m - _STRAIGHT_M * onward, door.position_m + _STRAIGHT_M * onward
        approach = _resampled(self._free.path(self._here, before))
        self._add(approach, np.zeros(len(approach), bool))
        straight = _resampled(np.stack([before, door.position_m, after]))
        self.crossed.append((sum(map(len, self.legs)) + len(straight) // 2 - 1, index))
        self._add(straight, np.linalg.norm(straight - door.position_m, axis=1) <= _FIXED_M)
        self._heading = onward
        return door.rooms[1] if door.rooms[0] == room else door.rooms[0]

    def wander(self, room: int, places: int) -> None:
        for _ in range(places):
            leg = _resampled(self._free.path(self._here, self._somewhere(room)))
            self._add(leg, np.arange(len(leg)) == len(leg) - 1)
            onward = leg[-1] - leg[max(0, len(leg) - 9)]
            self._heading = onward / max(float(np.linalg.norm(onward)), 1e-9)

    def _add(self, leg: NDArray[np.float64], fixed: NDArray[np.bool_]) -> None:
        self.legs.append(leg[1:])
        self.fixed.append(fixed[1:])
        self._here = leg[-1]

    def _somewhere(self, room: int) -> NDArray[np.float64]:
        inner = self._plan.clear(room).grown(-0.5)
        low, high = np.array([inner.x0, inner.y0]), np.array([inner.x1, inner.y1])
        return self._free.random_point(self._rng, low, high, self._here, self._heading)


def _arc_m(points_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N,) length of the path up to each point [m]."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points_m, axis=0), axis=1))])


def _resampled(points_m: NDArray[np.float64]) -> NDArray[np.float64]:
    at = _arc_m(points_m)
    count = max(2, round(at[-1] / STEP_M) + 1)
    wanted = np.linspace(0, at[-1], count)
    return np.column_stack([np.interp(wanted, at, points_m[:, axis]) for axis in (0, 1)])


def _smoothed(
    points_m: NDArray[np.float64], fixed: NDArray[np.bool_], free: FreeSpace
) -> NDArray[np.float64]:
    """The path relaxed like a stretched band: corners round off, but not through things and not at doors."""
    x_m, y_m = points_m.T.copy()
    moves = ~fixed
    moves[[0, -1]] = False
    reaches = np.repeat(_REACHES, _SMOOTHING_STEPS)
    relax(x_m, y_m, moves, reaches, free.clearance_m, CELL_M, CLEARANCE_M)
    points = np.column_stack([x_m, y_m])
    rounded = gaussian_filter1d(points, _ROUNDING_M / STEP_M, axis=0, mode="nearest")
    return np.asarray(rounded)
