"""Taken floor of a room, and whether one can still walk through it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from scipy import ndimage

from tacos_worlds.indoor.floor_plan import Door
from tacos_worlds.indoor.furnishing.arrangement import Arrangement, placed_rect
from tacos_worlds.indoor.structure.sides import Side
from tacos_worlds.kit.piece import Piece
from tacos_worlds.kit.rectangle import Rect

WALKWAY_M = 0.45
"""Half the width that must stay free between the doors of a room [m]."""
_CELL_M = 0.1
_DOOR_REACH_M = 1.0
_GAP_M = 0.04


class RoomFloor:
    """The floor of one room while it is being furnished.

    - `clear`: the room between its walls [m].
    - `sides`: its four sides, south, east, north, west.
    - `doors`: its doors; the floor in front of them stays free.
    - `reserved`: floor that furniture must leave free (door leaves, curtains) [m].
    """

    def __init__(self, clear: Rect, sides: list[Side], doors: list[Door], reserved: list[Rect]) -> None:
        self.clear = clear
        self.sides = sides
        self.taken: list[Rect] = []
        self._rugs: list[Rect] = []
        self.placed: list[Arrangement] = []
        self._doors = doors
        self._reserved = [door.zone(_DOOR_REACH_M, 0.15) for door in doors] + reserved
        self._walkable = self._empty_floor(reserved)

    def _cell_centres(self) -> tuple[np.ndarray, np.ndarray]:
        width, depth = self.clear.size
        x = self.clear.x0 + (np.arange(math.ceil(width / _CELL_M)) + 0.5) * _CELL_M
        y = self.clear.y0 + (np.arange(math.ceil(depth / _CELL_M)) + 0.5) * _CELL_M
        return x, y

    def _empty_floor(self, reserved: list[Rect]) -> np.ndarray:
        x, y = self._cell_centres()
        walkable = np.ones((len(x), len(y)), bool)
        inner = self.clear.grown(-WALKWAY_M)
        walkable &= ((x > inner.x0) & (x < inner.x1))[:, None] & ((y > inner.y0) & (y < inner.y1))[None, :]
        for rect in reserved:
            self._block(walkable, rect)
        for door in self._doors:  # the way in always counts as free
            zone = door.zone(_DOOR_REACH_M)
            narrow = zone.grown(-0.25)
            along = (
                Rect(narrow.x0, zone.y0, narrow.x1, zone.y1)
                if door.axis == 1
                else Rect(zone.x0, narrow.y0, zone.x1, narrow.y1)
            )
            walkable |= self._inside(along)
        return walkable

    def _inside(self, rect: Rect) -> np.ndarray:
        x, y = self._cell_centres()
        return np.asarray(((x > rect.x0) & (x < rect.x1))[:, None] & ((y > rect.y0) & (y < rect.y1))[None, :])

    def _block(self, walkable: np.ndarray, rect: Rect) -> None:
        walkable &= ~self._inside(rect.grown(WALKWAY_M))

    def _connected(self, walkable: np.ndarray) -> bool:
        """True if all doors lie on one connected piece of free floor, and enough of it is left."""
        label, count = ndimage.label(walkable)
        if count == 0:
            return False
        seen = set()
        for door in self._doors:
            inside = label[self._inside(door.zone(_DOOR_REACH_M + 0.1))]
            found = set(inside[inside > 0].tolist())
            if not found:
                return False
            seen.add(int(np.bincount(inside[inside > 0]).argmax()))
        largest = int(np.bincount(label[label > 0]).argmax())
        return seen <= {largest} and int((label == largest).sum()) * _CELL_M**2 > 3.0

    def try_at(self, arrangement: Arrangement, x_m: float, y_m: float, quarter_turns: int) -> bool:
        """Place the arrangement there if it fits; whether it did."""
        rects = [(m, placed_rect(m.footprint, x_m, y_m, quarter_turns)) for m in arrangement.members]
        # A rug that would lie on another one, or not fit, is left out.
        rects = [(m, r) for m, r in rects if not m.flat or self._rug_fits(r)]
        if not rects or not all(self.clear.contains(rect) for _, rect in rects):
            return False
        blocking = [rect for m, rect in rects if m.blocks]
        for rect in blocking:
            if any(rect.overlaps(other, _GAP_M) for other in self.taken):
                return False
            if any(rect.overlaps(other) for other in self._reserved):
                return False
        walkable = self._walkable.copy()
        for rect in blocking:
            self._block(walkable, rect)
        if not self._connected(walkable):
            return False
        self._walkable = walkable
        self.taken += blocking
        self._rugs += [rect for m, rect in rects if m.flat]
        kept = Arrangement(tuple(m for m, _ in rects))
        self.placed.append(kept.set_at(x_m, y_m, quarter_turns))
        return True

    def add_blocking(self, arrangement: Arrangement, *, over: Sequence[Rect]) -> bool:
        """Leave an arrangement where it is, partly over what stands there already, if one can still walk."""
        rects = [m.footprint for m in arrangement.members]
        others = [rect for rect in self.taken if rect not in over]
        if not all(self.clear.contains(rect) for rect in rects):
            return False
        if any(rect.overlaps(other) for rect in rects for other in [*others, *self._reserved]):
            return False
        walkable = self._walkable.copy()
        for rect in rects:
            self._block(walkable, rect)
        if not self._connected(walkable):
            return False
        self._walkable = walkable
        self.taken += rects
        self.placed.append(arrangement)
        return True

    def _rug_fits(self, rect: Rect) -> bool:
        return self.clear.contains(rect) and not any(rect.overlaps(other, _GAP_M) for other in self._rugs)

    def filled(self) -> float:
        return sum(rect.size[0] * rect.size[1] for rect in self.taken) / self.area_m2()

    def area_m2(self) -> float:
        return self.clear.size[0] * self.clear.size[1]

    def triangle_count(self) -> int:
        meshes = (mesh for made in self.placed for m in made.members for mesh, _ in m.piece.parts)
        return sum(len(mesh.triangles) for mesh in meshes)

    def replace_pieces(self, changed: Callable[[Piece], Piece]) -> None:
        self.placed = [
            Arrangement(tuple(replace(m, piece=changed(m.piece)) for m in made.members))
            for made in self.placed
        ]

    def place_at_wall(
        self, rng: np.random.Generator, arrangement: Arrangement, *, tries: int = 24, corner: bool = False
    ) -> bool:
        """Place it with its back to some wall, or in some corner; whether a place was found."""
        low = min(m.footprint.x0 for m in arrangement.members)
        high = max(m.footprint.x1 for m in arrangement.members)
        for _ in range(tries):
            turns = int(rng.integers(4))
            side = self.sides[turns]
            slack = side.length_m - (high - low) - 0.06
            if slack < 0:
                continue
            share = float(rng.integers(2)) if corner else rng.uniform()
            along = 0.03 - low + share * slack
            if self.try_at(arrangement, *side.point(along, 0.0), turns):
                return True
        return False

    def place_inside(
        self, rng: np.random.Generator, arrangement: Arrangement, *, tries: int = 24, spread: float = 0.35
    ) -> bool:
        """Place it away from the walls, near the middle for a small `spread`; whether a place was found."""
        width, depth = self.clear.size
        x, y = self.clear.centre
        for attempt in range(tries):
            reach = spread * (attempt + 1) / tries
            at = x + rng.uniform(-reach, reach) * width, y + rng.uniform(-reach, reach) * depth
            if self.try_at(arrangement, *at, int(rng.integers(4))):
                return True
        return False
