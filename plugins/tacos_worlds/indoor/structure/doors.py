"""Doorways: lining, casings, an open leaf, and the threshold."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tacos_worlds.indoor.floor_plan import WALL_M, Door, FloorPlan
from tacos_worlds.kit.finishes import CHROME, GOLD, Finish, Style
from tacos_worlds.kit.mesh import Mesh
from tacos_worlds.kit.piece import BACKGROUND, Piece
from tacos_worlds.kit.rectangle import Rect
from tacos_worlds.kit.shapes import box, tube

LINING_M = 0.03
"""Thickness of the frame inside the hole in the wall [m]."""
CASING_M = 0.07
"""Width of the boards around a doorway [m]."""
_LEAF_M = 0.04


@dataclass(frozen=True)
class OpenLeaf:
    """A door leaf that stands open: the piece, and the floor it takes."""

    piece: Piece
    footprint: Rect


def threshold(rng: np.random.Generator, door: Door) -> Piece:
    depth, height = WALL_M + rng.uniform(0.05, 0.10), rng.uniform(0.03, 0.045)
    sill = box((door.width_m - 0.002, depth, height), bevel_m=0.012)
    return _in_doorway(Piece("threshold", ((sill, GOLD),)), door)


def frame(door: Door, trim: Finish) -> Piece:
    """Lining and casings of a doorway; they carry no label."""
    width, height = door.width_m, door.height_m
    depth = WALL_M + 0.016
    parts: list[Mesh] = [box((width + 2 * LINING_M, depth, LINING_M), (0, 0, height), bevel_m=0.003)]
    for x in (-1, 1):
        parts.append(box((LINING_M, depth, height), (x * (width + LINING_M) / 2, 0, 0), bevel_m=0.003))
        parts.append(box((0.012, 0.03, height), (x * (width / 2 - 0.006), 0.01, 0), bevel_m=0.002))
        for y in (-1, 1):
            at = (x * (width / 2 + 0.008 + CASING_M / 2), y * (WALL_M / 2 + 0.009), 0.0)
            parts.append(box((CASING_M, 0.018, height + 0.008), at, bevel_m=0.005))
    for y in (-1, 1):
        at = (0.0, y * (WALL_M / 2 + 0.009), height + 0.008)
        parts.append(box((width + 0.016 + 2 * CASING_M, 0.018, CASING_M), at, bevel_m=0.005))
    return _in_doorway(Piece(BACKGROUND, tuple((mesh, trim) for mesh in parts)), door)


def open_leaf(rng: np.random.Generator, plan: FloorPlan, door: Door, style: Style) -> OpenLeaf | None:
    """A leaf opened into one of the rooms, or None where none fits."""
    into = int(rng.choice([-1, 1]))  # the room it opens into: lower or upper side
    hinge = int(rng.choice([-1, 1]))
    angle = math.radians(rng.uniform(92, 165))
    width, height = door.width_m - 0.006, door.height_m - 0.012
    panels: list[tuple[Mesh, Finish]] = [
        (box((width, _LEAF_M, height), (width / 2, 0, 0), bevel_m=0.004), style.trim)
    ]
    for low, high in ((0.18, 0.42), (0.50, 0.92)):
        for y in (-1, 1):
            at = (width / 2, y * (_LEAF_M / 2 + 0.003), height * low)
            panels.append((box((width - 0.28, 0.008, height * (high - low)), at, bevel_m=0.004), style.trim))
    for y in (-1, 1):
        path = [
            [width - 0.06, y * 0.02, 1.02],
            [width - 0.06, y * 0.065, 1.02],
            [width - 0.17, y * 0.068, 1.02],
        ]
        panels.append((tube(path, 0.01, sides=6), CHROME))
    leaf = Piece(BACKGROUND, tuple(panels)).moved(0, 0, 0.008)
    # Closed it would lie along the wall from its hinge; it swings away from the opening's middle.
    closed = 0.0 if hinge < 0 else math.pi
    swing = angle if (hinge < 0) == (into > 0) else -angle
    leaf = leaf.turned(closed + swing)
    leaf = leaf.moved(hinge * (door.width_m / 2 + 0.004), into * (WALL_M / 2 + _LEAF_M / 2 + 0.03))
    leaf = _in_doorway(leaf, door)
    low_m, high_m = leaf.bounds_m
    footprint = Rect(float(low_m[0]), float(low_m[1]), float(high_m[0]), float(high_m[1]))
    # `_in_doorway` turns local y along the passage for axis 1 and its opposite for axis 0.
    upper = into > 0 if door.axis == 1 else into < 0
    room = door.rooms[1] if upper else door.rooms[0]
    blocked = any(
        footprint.overlaps(other.zone(0.9, 0.1)) for other in plan.doors_of(room) if other is not door
    )
    fits = plan.clear(room).grown(0.004).contains(footprint)
    return OpenLeaf(leaf, footprint) if fits and not blocked else None


def _in_doorway(thing: Piece, door: Door) -> Piece:
    """A piece given with x along the wall and y along the passage, set into the doorway."""
    return thing.turned(math.pi / 2 if door.axis == 0 else 0.0).moved(door.x_m, door.y_m)
