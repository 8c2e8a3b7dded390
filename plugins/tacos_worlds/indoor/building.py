"""A whole floor: plan, shell, doors, windows, lights, furniture."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tacos_worlds.indoor.finishes import Finish, draw_style
from tacos_worlds.indoor.floor_plan import FloorPlan, Rect, draw_floor_plan
from tacos_worlds.indoor.furnishing.arrangement import Member
from tacos_worlds.indoor.furnishing.catalogue import Catalogue
from tacos_worlds.indoor.furnishing.occupancy import RoomFloor
from tacos_worlds.indoor.furnishing.pictures import hang_pictures
from tacos_worlds.indoor.furnishing.rooms import Furnisher, draw_room_kinds
from tacos_worlds.indoor.piece import Piece
from tacos_worlds.indoor.structure import doors as doorways
from tacos_worlds.indoor.structure.ceiling import ceiling_lights
from tacos_worlds.indoor.structure.shell import shell
from tacos_worlds.indoor.structure.sides import door_openings, sides_of
from tacos_worlds.indoor.structure.windows import CURTAIN_M, draw_windows, window

MAX_LIGHTS = 12
"""Ceiling lights and lamps that are on, in a whole building."""
_LUMINOUS_EXITANCE_LM_M2 = 140.0
_LARGE_ROOM_M2 = 45.0
_CELLS_PER_FLOOR = 750
_FURNITURE_TRIANGLES = 45_000
"""Shared by all rooms; beyond its share a room gets no more than what makes it such a room."""


@dataclass(frozen=True, eq=False)
class Building:
    """A furnished floor.

    Parameters
    ----------
    plan
        Rooms and doors.
    room_kinds
        What each room is used for.
    background
        Pieces without label: structure and decoration.
    thresholds
        One a door, in the order of the doors.
    furniture
        Everything that was placed on the floor or on other furniture, labelled or not.
    leaves
        Floor taken by open door leaves [m].
    """

    plan: FloorPlan
    room_kinds: tuple[str, ...]
    background: tuple[Piece, ...]
    thresholds: tuple[Piece, ...]
    furniture: tuple[Member, ...]
    leaves: tuple[Rect, ...]


def draw_building(
    rng: np.random.Generator,
    *,
    size_m: tuple[float, float],
    ceiling_height_m: float,
    min_room_m: float,
    clutter: float,
    room_light: Sequence[float] = (1.0,),
    catalogue: Catalogue,
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
    lit = _lamps_per_room(kinds, MAX_LIGHTS - sum(fittings))
    step_m = max(0.55, math.sqrt(size_m[0] * size_m[1] / _CELLS_PER_FLOOR))
    temperature_k = float(room_rng.choice([5000.0, 5700.0, 6500.0]))
    furniture: list[Member] = []
    for room, stream in enumerate(room_rng.spawn(count)):
        style_rng, window_rng, furnish_rng, wall_rng, light_rng = stream.spawn(5)
        wet = kinds[room] == "bathroom"
        style = draw_style(style_rng, wet=wet)
        clear, sides = plan.clear(room), sides_of(plan, room)
        doors = [door_openings(plan, room, side, doorways.LINING_M) for side in sides]
        windows = [draw_windows(window_rng, side, ceiling_height_m, wet=wet) for side in sides]
        holes = [doors[k] + [w.opening for w in windows[k]] for k in range(4)]
        tiles = _wall_tiles(style_rng) if wet else None
        background.append(shell(clear, sides, holes, doors, ceiling_height_m, style, tiles, step_m))
        background += [
            window(window_rng, side, w, style)
            for side, found in zip(sides, windows, strict=True)
            for w in found
        ]
        dimmed = room_light[room % len(room_light)]
        flux_lm = dimmed * areas[room] * _LUMINOUS_EXITANCE_LM_M2
        background += ceiling_lights(
            light_rng, clear, ceiling_height_m, fittings[room], flux_lm, temperature_k
        )

        reserved = [
            side.rect(w.low_m, w.high_m, 0.0, CURTAIN_M)
            for side, found in zip(sides, windows, strict=True)
            for w in found
        ]
        floor = RoomFloor(clear, sides, plan.doors_of(room), reserved + leaves)
        lamps = lit[room] if dimmed == 1 else 0
        allowance = round(_FURNITURE_TRIANGLES * areas[room] / sum(areas))
        Furnisher(furnish_rng, floor, style, catalogue, clutter, lamps, allowance).furnish(kinds[room])
        members = [m for arrangement in floor.placed for m in arrangement.members]
        furniture += members
        for side, passages, found in zip(sides, doors, windows, strict=True):
            busy = [(o.low_m - 0.1, o.high_m + 0.1) for o in passages] + [
                (w.low_m - 0.1, w.high_m + 0.1) for w in found
            ]
            for rect in [m.footprint for m in members if m.height_m > 1.05] + leaves:
                along, off = zip(side.along(rect.x0, rect.y0), side.along(rect.x1, rect.y1), strict=True)
                if min(off) < 0.7 and min(off) > -0.1:
                    busy.append((min(along), max(along)))
            background += hang_pictures(
                wall_rng, side, busy, style, 0 if wet else int(wall_rng.integers(1, 4))
            )
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


def _wall_tiles(rng: np.random.Generator) -> Finish:
    if rng.uniform() < 0.7:
        tint = rng.uniform(0.75, 0.95) * np.array([1.0, 1.0, 1.0]) * rng.uniform(0.85, 1.0, 3)
        return Finish("wall_tiles", (float(tint[0]), float(tint[1]), float(tint[2])), roughness=0.2)
    return Finish("mosaic", variant=int(rng.integers(3)), roughness=0.2)
