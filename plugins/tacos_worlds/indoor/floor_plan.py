"""Floor plans: rectangular rooms cut out of a rectangle, joined by doors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tacos_worlds.kit.rectangle import Rect

WALL_M = 0.12
"""Thickness of the walls between rooms [m]."""
MAX_ROOMS = 9
"""A floor is not cut into more rooms; larger floors get larger rooms."""
_CUT_STEP_M = 0.25
_DOOR_TO_CORNER_M = 0.85
"""Least distance from the middle of a door to the end of its wall [m]."""


@dataclass(frozen=True)
class Door:
    """A doorway in the wall between two rooms."""

    rooms: tuple[int, int]  # indices of the rooms on its lower and upper side along `axis`
    axis: int  # 0 where one passes along x, 1 along y
    x_m: float
    y_m: float
    width_m: float
    height_m: float

    @property
    def position_m(self) -> np.ndarray:
        """(2,) middle on the floor [m]."""
        return np.array([self.x_m, self.y_m])

    @property
    def direction(self) -> np.ndarray:
        """(2,) unit vector from the first room into the second."""
        return np.array([1.0, 0.0]) if self.axis == 0 else np.array([0.0, 1.0])

    def zone(self, reach_m: float, side_m: float = 0.0) -> Rect:
        """The floor `reach_m` to either side of the wall, `side_m` wider than the opening at each end [m]."""
        along, across = reach_m, self.width_m / 2 + side_m
        half_x, half_y = (along, across) if self.axis == 0 else (across, along)
        return Rect(self.x_m - half_x, self.y_m - half_y, self.x_m + half_x, self.y_m + half_y)


@dataclass(frozen=True)
class FloorPlan:
    size_m: tuple[float, float]  # extent of the floor along x and y, from (0, 0) [m]
    cells: tuple[Rect, ...]  # rooms measured to the middle of the walls between them; they tile the floor [m]
    doors: tuple[Door, ...]

    def clear(self, room: int) -> Rect:
        """The room between the faces of its walls [m]."""
        cell = self.cells[room]
        half = WALL_M / 2
        return Rect(
            cell.x0 + (half if cell.x0 > 0 else 0),
            cell.y0 + (half if cell.y0 > 0 else 0),
            cell.x1 - (half if cell.x1 < self.size_m[0] else 0),
            cell.y1 - (half if cell.y1 < self.size_m[1] else 0),
        )

    def doors_of(self, room: int) -> list[Door]:
        return [door for door in self.doors if room in door.rooms]


def draw_floor_plan(rng: np.random.Generator, size_m: tuple[float, float], min_room_m: float) -> FloorPlan:
    """A random floor plan: guillotine cuts, then doors so that every room can be reached.

    Rooms are at least `min_room_m` along both edges, measured between the middles of inner walls and the
    faces of outer ones, as floor plans are.
    """
    cells = _cut(rng, Rect(0.0, 0.0, *size_m), min_room_m)
    return FloorPlan(size_m, tuple(cells), tuple(_doors(rng, cells)))


def _cut(rng: np.random.Generator, floor: Rect, min_room_m: float) -> list[Rect]:
    cells = [floor]
    while len(cells) < MAX_ROOMS:
        large = [c for c in cells if max(c.size) >= 2 * min_room_m]
        if not large:
            break
        cell = max(large, key=lambda c: c.size[0] * c.size[1])
        axis = int(np.argmax(cell.size))
        if min(cell.size) >= 2 * min_room_m and rng.uniform() < 0.5:
            axis = 1 - axis
        length = cell.size[axis]
        slack = length - 2 * min_room_m
        # A cut at the least width leaves room for another one beyond it.
        share = 0.0 if slack >= min_room_m and rng.uniform() < 0.4 else rng.uniform()
        offset = min_room_m + min(round(share * slack / _CUT_STEP_M) * _CUT_STEP_M, slack)
        if rng.uniform() < 0.5:
            offset = length - offset
        cells.remove(cell)
        if axis == 0:
            cut = cell.x0 + offset
            cells += [Rect(cell.x0, cell.y0, cut, cell.y1), Rect(cut, cell.y0, cell.x1, cell.y1)]
        else:
            cut = cell.y0 + offset
            cells += [Rect(cell.x0, cell.y0, cell.x1, cut), Rect(cell.x0, cut, cell.x1, cell.y1)]
    return cells


def _doors(rng: np.random.Generator, cells: list[Rect]) -> list[Door]:
    shared = []
    for first in range(len(cells)):
        for second in range(len(cells)):
            for axis in (0, 1):
                if wall := _shared_wall(cells[first], cells[second], axis):
                    shared.append((first, second, axis, *wall))
    group = list(range(len(cells)))
    doors = []
    for k in rng.permutation(len(shared)):
        first, second, axis, at, low, high = shared[k]
        needed = group[first] != group[second]
        extra = rng.uniform() < 0.3
        along = rng.uniform(low + _DOOR_TO_CORNER_M, high - _DOOR_TO_CORNER_M)
        width, height = rng.uniform(0.88, 1.0), rng.uniform(2.02, 2.1)
        if needed or extra:
            joined = group[second]
            group = [group[first] if g == joined else g for g in group]
            x, y = (at, along) if axis == 0 else (along, at)
            doors.append(Door((first, second), axis, float(x), float(y), float(width), float(height)))
    return doors


def _shared_wall(first: Rect, second: Rect, axis: int) -> tuple[float, float, float] | None:
    """(place across, start, end along) of the wall where `second` follows `first` along `axis`, or None."""
    if axis == 0:
        meets, low, high = first.x1 == second.x0, max(first.y0, second.y0), min(first.y1, second.y1)
        at = first.x1
    else:
        meets, low, high = first.y1 == second.y0, max(first.x0, second.x0), min(first.x1, second.x1)
        at = first.y1
    return (at, low, high) if meets and high - low > 2 * _DOOR_TO_CORNER_M + 0.3 else None
