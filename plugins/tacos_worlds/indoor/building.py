"""A whole floor: plan, shell, doors, windows, lights, furniture."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tacos_worlds.indoor.floor_plan import FloorPlan, draw_floor_plan
from tacos_worlds.indoor.furnishing.arrangement import Member
from tacos_worlds.indoor.furnishing.catalogue import Catalogue
from tacos_worlds.indoor.furnishing.rooms import draw_room_kinds
from tacos_worlds.indoor.room import RoomsToDraw, draw_room
from tacos_worlds.indoor.structure import doors as doorways
from tacos_worlds.kit.finishes import draw_style
from tacos_worlds.kit.piece import Piece
from tacos_worlds.kit.rectangle import Rect

MAX_LIGHTS = 12
"""Ceiling lights and lamps that are on, in a whole building."""
_LARGE_ROOM_M2 = 45.0
_CELLS_PER_FLOOR = 750


@dataclass(frozen=True, eq=False)
class Building:
    plan: FloorPlan
    room_kinds: tuple[str, ...]
    background: tuple[Piece, ...]  # pieces without label: structure and decoration
    thresholds: tuple[Piece, ...]  # one a door, in the order of the doors
    furniture: tuple[Member, ...]
    """Everything that was placed on the floor or on other furniture, labelled or not."""
    leaves: tuple[Rect, ...]  # floor taken by open door leaves [m]


def draw_building(
    rng: np.random.Generator,
    *,
    size_m: tuple[float, float],
    ceiling_height_m: float,
    min_room_m: float,
    clutter: float,
    people: float,
    catalogue: Catalogue,
    room_light: Sequence[float] = (1.0,),
) -> Building:
    """A random furnished floor; every room draws from its own stream of random numbers.

    `room_light` dims the ceiling lights of the rooms in turn [1]; where it is below 1, no lamp is on beside.
    """
    plan_rng, door_rng, room_rng = rng.spawn(3)
    plan = draw_floor_plan(plan_rng, size_m, min_room_m)
    count = len(plan.cells)
    areas = [cell.size[0] * cell.size[1] for cell in plan.cells]
    kinds = draw_room_kinds(plan_rng, areas)
    trim_style = draw_style(door_rng)
    background: list[Piece] = []
    leaves: list[Rect] = []
    for door in plan.doors:
        background.append(doorways.frame(door, trim_style.trim))
        leaf = doorways.open_leaf(door_rng, plan, door, trim_style) if door_rng.uniform() < 0.6 else None
        if leaf and not any(leaf.footprint.overlaps(other, 0.05) for other in leaves):
            background.append(leaf.piece)
            leaves.append(leaf.footprint)
    thresholds = [doorways.threshold(door_rng, door) for door in plan.doors]

    fittings = [2 if area > _LARGE_ROOM_M2 and count <= 6 else 1 for area in areas]
    rooms = RoomsToDraw(
        plan=plan,
        kinds=tuple(kinds),
        leaves=tuple(leaves),
        fittings=tuple(fittings),
        lamps=tuple(_lamps_per_room(kinds, MAX_LIGHTS - sum(fittings))),
        lights=tuple(room_light[room % len(room_light)] for room in range(count)),
        temperature_k=float(room_rng.choice([5000.0, 5700.0, 6500.0])),
        ceiling_height_m=ceiling_height_m,
        step_m=max(0.55, math.sqrt(size_m[0] * size_m[1] / _CELLS_PER_FLOOR)),
        catalogue=catalogue,
        clutter=clutter,
        people=people,
    )
    furniture: list[Member] = []
    for room, stream in enumerate(room_rng.spawn(count)):
        pieces, members = draw_room(stream, rooms, room)
        background += pieces
        furniture += members
    return Building(plan, tuple(kinds), tuple(background), tuple(thresholds), tuple(furniture), tuple(leaves))


def _lamps_per_room(kinds: list[str], budget: int) -> list[int]:
    """Two lamps on in rooms to rest in, one elsewhere, until the budget of lights is used up."""
    lit = [0] * len(kinds)
    for wanted in ("living", "bedroom", "office", "bedroom", "living"):
        for room, kind in enumerate(kinds):
            if kind == wanted and budget > 0 and lit[room] < 2:
                lit[room] += 1
                budget -= 1
    return lit
