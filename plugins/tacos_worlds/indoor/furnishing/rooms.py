"""Furniture of a living room, a bedroom, a bathroom, and so on."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from tacos_worlds.indoor.furnishing import groups
from tacos_worlds.indoor.furnishing.arrangement import Arrangement, alone, member, together
from tacos_worlds.indoor.furnishing.catalogue import Catalogue
from tacos_worlds.indoor.furnishing.occupancy import RoomFloor
from tacos_worlds.indoor.furnishing.occupants import welcome
from tacos_worlds.indoor.furnishing.tabletops import lay_out
from tacos_worlds.indoor.furniture.lamp import switched_on
from tacos_worlds.kit.finishes import Style
from tacos_worlds.kit.piece import Piece

LAMP_FLUX_LM = 450.0
"""Luminous flux of a lamp beside the ceiling lights, before calibration [lm]."""
LAMP_TEMPERATURE_K = 4300.0
_LARGE_M2 = 45.0
"""Larger rooms get twice as much beyond what makes them."""
_TOY_TRIANGLES = 400
"""Kept back for each toy while furniture is added."""
_FILLED = 0.26
"""Share of the floor that furniture takes in a furnished room [1]."""


@dataclass
class Furnisher:
    """Furnishes one room: first what makes the room, then more until it looks lived in."""

    rng: np.random.Generator
    floor: RoomFloor
    style: Style
    catalogue: Catalogue
    clutter: float  # 0 for few small things to 1 for many [1]
    lamps_lit: int  # how many lamps may be switched on
    triangles: int  # beyond this many triangles nothing is added that the room can do without

    def furnish(self, kind: str) -> None:
        essential, more, toys = ROOM_KINDS[kind]
        essential(self)
        toy_count = int(self.rng.poisson(toys * 2 * self.clutter))
        for_furniture = self.triangles - min(toy_count * _TOY_TRIANGLES, self.triangles // 3)
        rounds = 2 if self.floor.area_m2() > _LARGE_M2 else 1
        for name in self.rng.permutation(more.split(", ") * rounds).tolist():
            if self.floor.filled() > _FILLED or self.floor.triangle_count() > for_furniture:
                break
            _PLACE[name](self)
        for _ in range(toy_count):
            if self.floor.triangle_count() < 1.1 * self.triangles:
                self._toy()
        self.floor.replace_pieces(self._switched)

    def bring_to_life(self, rng: np.random.Generator, *, people: float, triangles: int) -> None:
        """People come in, and small things are left on tables.

        - `rng`: a stream of random numbers of its own, so that the furniture stays as it is without them.
        - `people`: their mean number [1].
        - `triangles`: small things have no more than so many.
        """
        welcome(rng, self.floor, people=people)
        lay_out(rng, self.floor, self.style, clutter=self.clutter, triangles=triangles)

    def make(self, kind: str) -> Piece:
        return self.catalogue.make(kind, self.rng, self.style)

    def at_wall(self, arrangement: Arrangement) -> bool:
        return self.floor.place_at_wall(self.rng, arrangement, tries=40)

    def in_corner(self, kind: str) -> bool:
        return self.floor.place_at_wall(self.rng, alone(self.make(kind), gap_m=0.08), corner=True)

    def inside(self, arrangement: Arrangement, spread: float = 0.35) -> bool:
        return self.floor.place_inside(self.rng, arrangement, tries=40, spread=spread)

    def _switched(self, thing: Piece) -> Piece:
        if thing.class_name == "lamp" and thing.can_light and self.lamps_lit > 0:
            self.lamps_lit -= 1
            return switched_on(thing, LAMP_FLUX_LM, LAMP_TEMPERATURE_K)
        return thing

    def _toy(self) -> None:
        made = together([member(self.make("toy"), yaw_rad=self.rng.uniform(0, 2 * math.pi))])
        self.floor.place_inside(self.rng, made, spread=0.47, tries=12)

    def _living(self) -> None:
        for _ in range(3):
            if self.at_wall(groups.television_corner(self.rng, self.make, self.style)):
                break
        else:
            self.at_wall(groups.on_top(self.rng, self.make("sideboard"), self.make("television")))
            self.at_wall(groups.sofa_at_wall(self.rng, self.make, self.style))
        self.in_corner("floor_lamp")
        self.in_corner("floor_plant")

    def _bedroom(self) -> None:
        for kind in ("bed", "bed", "single_bed"):
            if self.at_wall(groups.bed_between_lamps(self.rng, self.make, self.style, kind)):
                break
        self.at_wall(alone(self.make("wardrobe")))
        self.in_corner("floor_plant")

    def _children(self) -> None:
        for _ in range(int(self.rng.integers(1, 3))):
            self.at_wall(groups.bed_between_lamps(self.rng, self.make, self.style, "single_bed"))
        self.at_wall(groups.workplace(self.rng, self.make, self.style))
        self.inside(together([groups.rug(self.rng, self.style, 2.0, 1.5)]), spread=0.2)

    def _bathroom(self) -> None:
        tub = self.make("bathtub").turned(math.pi * int(self.rng.integers(2)))
        self.floor.place_at_wall(self.rng, alone(tub), tries=60, corner=True)
        for _ in range(int(self.rng.integers(1, 3))):
            self.at_wall(alone(self.make("basin")))
        self.at_wall(alone(self.make("toilet")))
        self.in_corner("floor_plant")
        self.inside(together([groups.rug(self.rng, self.style, 1.1, 0.7)]))

    def _dining(self) -> None:
        self.at_wall(alone(self.make("kitchen_unit")))
        self.at_wall(alone(self.make("fridge")))
        self.inside(groups.table_with_chairs(self.rng, self.make, self.style))
        self.in_corner("floor_plant")

    def _office(self) -> None:
        for _ in range(int(self.rng.integers(1, 4))):
            self.at_wall(groups.workplace(self.rng, self.make, self.style))
        self.at_wall(alone(self.make("bookshelf")))
        self.in_corner("floor_lamp")
        self.inside(together([groups.rug(self.rng, self.style, 2.4, 1.7)]), spread=0.15)


def _single(kind: str) -> Callable[[Furnisher], object]:
    return lambda furnisher: furnisher.at_wall(alone(furnisher.make(kind)))


def _corner(kind: str) -> Callable[[Furnisher], object]:
    return lambda furnisher: furnisher.in_corner(kind)


def _topped(kind: str, top: str) -> Callable[[Furnisher], object]:
    return lambda f: f.at_wall(groups.on_top(f.rng, f.make(kind), f.make(top)))


def _group(
    make_group: Callable[[np.random.Generator, groups.Make, Style], Arrangement], *, inside: bool = False
) -> Callable[[Furnisher], object]:
    def place(furnisher: Furnisher) -> bool:
        made = make_group(furnisher.rng, furnisher.make, furnisher.style)
        return furnisher.inside(made) if inside else furnisher.at_wall(made)

    return place


_PLACE: Mapping[str, Callable[[Furnisher], object]] = {
    "bookshelf": _single("bookshelf"),
    "wardrobe": _single("wardrobe"),
    "kitchen_unit": _single("kitchen_unit"),
    "washing_machine": _single("washing_machine"),
    "laundry_basket": _single("laundry_basket"),
    "armchair": _corner("armchair"),
    "floor_plant": _corner("floor_plant"),
    "floor_lamp": _corner("floor_lamp"),
    "chest": _topped("chest", "small_plant"),
    "chest with lamp": _topped("chest", "table_lamp"),
    "sideboard": _topped("sideboard", "small_plant"),
    "television": _topped("sideboard", "television"),
    "sofa": _group(groups.sofa_at_wall),
    "reading corner": _group(groups.reading_corner),
    "workplace": _group(groups.workplace),
    "table with chairs": _group(groups.table_with_chairs, inside=True),
}

ROOM_KINDS: Mapping[str, tuple[Callable[[Furnisher], None], str, float]] = {
    "living": (
        Furnisher._living,
        "bookshelf, bookshelf, reading corner, sideboard, sofa, table with chairs, floor_plant, chest",
        1.5,
    ),
    "bedroom": (
        Furnisher._bedroom,
        "chest, chest with lamp, wardrobe, reading corner, bookshelf, workplace, floor_plant, armchair",
        1.0,
    ),
    "bathroom": (
        Furnisher._bathroom,
        "washing_machine, washing_machine, laundry_basket, chest, wardrobe, floor_plant, laundry_basket",
        0.6,
    ),
    "dining": (
        Furnisher._dining,
        "kitchen_unit, sideboard, bookshelf, chest, floor_plant, floor_plant, sofa, television, armchair",
        0.8,
    ),
    "office": (
        Furnisher._office,
        "bookshelf, bookshelf, workplace, table with chairs, reading corner, sideboard, floor_plant, sofa",
        0.5,
    ),
    "children": (
        Furnisher._children,
        "bookshelf, chest, wardrobe, armchair, chest with lamp, workplace, floor_plant, bookshelf",
        6.0,
    ),
}
"""For each kind of room: what makes it, what may be added (once a
mention), and how many toys lie about at medium clutter."""


def draw_room_kinds(rng: np.random.Generator, areas_m2: list[float]) -> list[str]:
    """A kind for each room, each once before any twice; bathrooms are small, living rooms large."""
    first = ["living", "bedroom", "bathroom", "dining", "office", "children"]
    more = ["bedroom", "office", "living", "children", "dining"]
    wanted = first[: len(areas_m2)] + [more[k % len(more)] for k in range(max(0, len(areas_m2) - len(first)))]
    if len(areas_m2) == 4 and rng.uniform() < 0.5:
        wanted[3] = "office"
    kinds = [""] * len(areas_m2)
    by_area = list(np.argsort(areas_m2))
    if "bathroom" in wanted:
        wanted.remove("bathroom")
        kinds[by_area.pop(0)] = "bathroom"
    wanted.remove("living")
    kinds[by_area.pop(-1)] = "living"
    for room, kind in zip(by_area, rng.permutation(wanted).tolist(), strict=True):
        kinds[room] = kind
    return kinds
