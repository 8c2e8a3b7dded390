"""One room of a floor: shell, windows, lights, furniture, pictures on its walls."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tacos_worlds.indoor.floor_plan import FloorPlan
from tacos_worlds.indoor.furnishing.arrangement import Member
from tacos_worlds.indoor.furnishing.catalogue import Catalogue
from tacos_worlds.indoor.furnishing.occupancy import RoomFloor
from tacos_worlds.indoor.furnishing.pictures import hang_pictures
from tacos_worlds.indoor.furnishing.rooms import Furnisher
from tacos_worlds.indoor.structure import doors as doorways
from tacos_worlds.indoor.structure.ceiling import ceiling_lights
from tacos_worlds.indoor.structure.shell import shell
from tacos_worlds.indoor.structure.sides import Opening, Side, door_openings, sides_of
from tacos_worlds.indoor.structure.windows import CURTAIN_M, Window, draw_windows, window
from tacos_worlds.kit.finishes import Finish, draw_style
from tacos_worlds.kit.piece import Piece
from tacos_worlds.kit.rectangle import Rect

_LUMINOUS_EXITANCE_LM_M2 = 140.0
_SMALL_THINGS_TRIANGLES = 9_000
_FURNITURE_TRIANGLES = 45_000
"""Shared by all rooms; beyond its share a room gets no more than what makes it such a room."""
_TALL_M = 1.05
"""Furniture higher than this hides the wall behind it."""


@dataclass(frozen=True, eq=False)
class RoomsToDraw:
    """Facts of a floor that are settled before its rooms are drawn."""

    plan: FloorPlan
    kinds: tuple[str, ...]  # of each room what it is used for
    fittings: tuple[int, ...]  # of each room its ceiling lights
    lamps: tuple[int, ...]  # of each room those that may be on
    lights: tuple[float, ...]  # of each room over the brightest [1]
    leaves: tuple[Rect, ...]  # floor taken by open door leaves [m]
    temperature_k: float
    ceiling_height_m: float
    step_m: float  # edge of the cells of surfaces
    catalogue: Catalogue
    clutter: float  # small things over what is usual [1]
    people: float  # over what is usual [1]

    def area_m2(self, room: int) -> float:
        width_m, depth_m = self.plan.cells[room].size
        return width_m * depth_m

    def share(self, room: int) -> float:
        """Its share of the whole floor [1]."""
        return self.area_m2(room) / sum(map(self.area_m2, range(len(self.plan.cells))))


def draw_room(rng: np.random.Generator, rooms: RoomsToDraw, room: int) -> tuple[list[Piece], list[Member]]:
    """A room by its number: its pieces without label, and what was placed on its floor."""
    style_rng, window_rng, furnish_rng, wall_rng, light_rng, life_rng = rng.spawn(6)
    plan, height_m, wet = rooms.plan, rooms.ceiling_height_m, rooms.kinds[room] == "bathroom"
    style = draw_style(style_rng, wet=wet)
    clear, sides = plan.clear(room), sides_of(plan, room)
    doors = [door_openings(plan, room, side, doorways.LINING_M) for side in sides]
    windows = [draw_windows(window_rng, side, height_m, wet=wet) for side in sides]
    holes = [[*passages, *(w.opening for w in found)] for passages, found in zip(doors, windows, strict=True)]
    tiles = _wall_tiles(style_rng) if wet else None
    panes = [(side, w) for side, found in zip(sides, windows, strict=True) for w in found]
    pieces = [shell(clear, sides, holes, doors, height_m, style, tiles, rooms.step_m)]
    pieces += [window(window_rng, side, w, style) for side, w in panes]
    flux_lm = rooms.lights[room] * rooms.area_m2(room) * _LUMINOUS_EXITANCE_LM_M2
    pieces += ceiling_lights(light_rng, clear, height_m, rooms.fittings[room], flux_lm, rooms.temperature_k)

    curtains = [side.rect(w.low_m, w.high_m, 0.0, CURTAIN_M) for side, w in panes]
    floor = RoomFloor(clear, sides, plan.doors_of(room), [*curtains, *rooms.leaves])
    lamps = rooms.lamps[room] if rooms.lights[room] == 1 else 0
    allowance = round(_FURNITURE_TRIANGLES * rooms.share(room))
    furnisher = Furnisher(furnish_rng, floor, style, rooms.catalogue, rooms.clutter, lamps, allowance)
    furnisher.furnish(rooms.kinds[room])
    company = 0.0 if wet else rooms.people
    furnisher.bring_to_life(
        life_rng, people=company, triangles=round(_SMALL_THINGS_TRIANGLES * rooms.share(room))
    )
    members = [m for arrangement in floor.placed for m in arrangement.members]
    hidden = [m.footprint for m in members if m.height_m > _TALL_M] + list(rooms.leaves)
    for side, passages, found in zip(sides, doors, windows, strict=True):
        most = 0 if wet else int(wall_rng.integers(1, 4))
        pieces += hang_pictures(wall_rng, side, _busy(side, [*passages, *found], hidden), style, most)
    return pieces, members


def _busy(side: Side, taken: Sequence[Opening | Window], hidden: Sequence[Rect]) -> list[tuple[float, float]]:
    """Parts of a wall where no picture can hang: doors, windows, and what things stand before [m]."""
    busy = [(each.low_m - 0.1, each.high_m + 0.1) for each in taken]
    for rect in hidden:
        along, off = zip(side.along(rect.x0, rect.y0), side.along(rect.x1, rect.y1), strict=True)
        if -0.1 < min(off) < 0.7:
            busy.append((min(along), max(along)))
    return busy


def _wall_tiles(rng: np.random.Generator) -> Finish:
    if rng.uniform() < 0.7:
        tint = rng.uniform(0.75, 0.95) * np.array([1.0, 1.0, 1.0]) * rng.uniform(0.85, 1.0, 3)
        return Finish("wall_tiles", (float(tint[0]), float(tint[1]), float(tint[2])), roughness=0.2)
    return Finish("mosaic", variant=int(rng.integers(3)), roughness=0.2)
