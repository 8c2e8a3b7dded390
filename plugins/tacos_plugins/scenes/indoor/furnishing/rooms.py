"""What stands in a living room, a bedroom, a bathroom, and so on."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from tacos_plugins.scenes.indoor.finishes import Style
from tacos_plugins.scenes.indoor.furnishing.arrangement import (
    Arrangement,
    Member,
    against_wall,
    alone,
    member,
    together,
)
from tacos_plugins.scenes.indoor.furnishing.catalogue import Catalogue
from tacos_plugins.scenes.indoor.furnishing.occupancy import RoomFloor
from tacos_plugins.scenes.indoor.furniture.lamp import switched_on
from tacos_plugins.scenes.indoor.piece import BACKGROUND, Piece, piece
from tacos_plugins.scenes.indoor.shapes import box

LAMP_FLUX_LM = 450.0
LAMP_TEMPERATURE_K = 4200.0


@dataclass
class Furnisher:
    """Furnishes one room; each method of a kind of room places what belongs there.

    Parameters
    ----------
    rng
        The room's stream of random numbers.
    floor
        The room's floor.
    style
        The room's finishes.
    catalogue
        Where furniture comes from.
    clutter
        0 for few small things to 1 for many [1].
    lamps_lit
        How many lamps may still be switched on.
    """

    rng: np.random.Generator
    floor: RoomFloor
    style: Style
    catalogue: Catalogue
    clutter: float
    lamps_lit: int

    def make(self, kind: str) -> Piece:
        """One piece of furniture; lamps are switched on while the room's allowance lasts."""
        made = self.catalogue.make(kind, self.rng, self.style)
        if made.class_name == "lamp" and self.lamps_lit > 0:
            self.lamps_lit -= 1
            return switched_on(made, LAMP_FLUX_LM, LAMP_TEMPERATURE_K)
        return made

    def living(self) -> None:
        """Sofa opposite the television, coffee table on a rug between them, armchairs, shelves."""
        for _ in range(3):
            if self.floor.place_at_wall(self.rng, self._television_corner(), tries=40):
                break
        else:
            self._at_wall("sofa")
            self.floor.place_at_wall(self.rng, self._on(self.make("sideboard"), self.make("television")))
        self._at_wall("bookshelf")
        self._lamp_in_corner()
        self._in_corner("floor_plant")
        if self.rng.uniform() < 0.6:
            self._at_wall("bookshelf")
        if self.rng.uniform() < 0.5:
            self.floor.place_at_wall(self.rng, self._on(self.make("chest"), self.make("small_plant")))
        self._toys(self.rng.poisson(1.5 * self.clutter))

    def bedroom(self) -> None:
        """Bed between night stands with lamps, wardrobe, chest."""
        self.floor.place_at_wall(self.rng, self._bed_between_lamps("bed"), tries=60) or self._at_wall(
            "single_bed"
        )
        self._at_wall("wardrobe")
        if self.rng.uniform() < 0.6:
            self.floor.place_at_wall(self.rng, self._on(self.make("chest"), self.make("small_plant")))
        if self.rng.uniform() < 0.6:
            self._in_corner("armchair")
        self._in_corner("floor_plant")
        if self.rng.uniform() < 0.35:
            self.floor.place_at_wall(self.rng, self._workplace())
        self._toys(self.rng.poisson(1.0 * self.clutter))

    def children(self) -> None:
        """Beds for children, a table to draw at, many toys."""
        for _ in range(int(self.rng.integers(1, 3))):
            self.floor.place_at_wall(self.rng, self._bed_between_lamps("single_bed"), tries=60)
        self._at_wall("wardrobe")
        self.floor.place_at_wall(self.rng, self._workplace())
        self._at_wall("bookshelf")
        self._rug(1.8, 1.3)
        self._toys(3 + self.rng.poisson(5 * self.clutter))

    def bathroom(self) -> None:
        """Tub, one or two basins, toilet, a plant."""
        self.floor.place_at_wall(self.rng, alone(self.make("bathtub").turned(math.pi)), tries=60, corner=True)
        for _ in range(int(self.rng.integers(1, 3))):
            self._at_wall("basin")
        self._at_wall("toilet")
        self._at_wall("chest")
        if self.rng.uniform() < 0.8:
            self._in_corner("floor_plant")
        self._rug(0.9, 0.6, spread=0.3)
        self._toys(self.rng.poisson(0.6 * self.clutter))

    def dining(self) -> None:
        """A table with chairs around it, a kitchen unit, a sideboard."""
        self.floor.place_at_wall(self.rng, alone(self.make("kitchen_unit")), tries=40)
        self.floor.place_inside(self.rng, self._table_with_chairs(), tries=40)
        self.floor.place_at_wall(self.rng, self._on(self.make("sideboard"), self.make("small_plant")))
        self._in_corner("floor_plant")
        if self.rng.uniform() < 0.5:
            self._lamp_in_corner()
        if self.rng.uniform() < 0.5:
            self._at_wall("bookshelf")
        self._toys(self.rng.poisson(0.7 * self.clutter))

    def office(self) -> None:
        """Desks with computers, shelves, an armchair to read in."""
        for _ in range(int(self.rng.integers(1, 4))):
            self.floor.place_at_wall(self.rng, self._workplace(), tries=40)
        for _ in range(int(self.rng.integers(1, 4))):
            self._at_wall("bookshelf")
        self._lamp_in_corner()
        if self.rng.uniform() < 0.7:
            self._in_corner("armchair")
        self._in_corner("floor_plant")
        self._rug(2.0, 1.4)
        self._toys(self.rng.poisson(0.5 * self.clutter))

    def _at_wall(self, kind: str) -> bool:
        return self.floor.place_at_wall(self.rng, alone(self.make(kind)))

    def _in_corner(self, kind: str) -> bool:
        return self.floor.place_at_wall(self.rng, alone(self.make(kind), gap_m=0.08), corner=True)

    def _lamp_in_corner(self) -> None:
        self._in_corner("floor_lamp")

    def _on(self, support: Piece, thing: Piece) -> Arrangement:
        """Something on a cupboard at the wall."""
        base = against_wall(support)
        share = 0.0 if thing.class_name == "computer_tv" else self.rng.uniform(-0.3, 0.3)
        top = member(
            thing, share * support.size_m[0], base.footprint.y0 + support.size_m[1] / 2, support.size_m[2]
        )
        return together([base, top])

    def _television_corner(self) -> Arrangement:
        rng = self.rng
        stand = against_wall(self.make("sideboard"))
        screen = self.make("television")
        seat, low_table = self.make("sofa"), self.make("coffee_table")
        members = [stand, member(screen, 0, stand.footprint.y1 - 0.2, stand.height_m)]
        table_at = stand.footprint.y1 + rng.uniform(1.0, 1.3) + low_table.size_m[1] / 2
        sofa_at = table_at + low_table.size_m[1] / 2 + rng.uniform(0.38, 0.5) + seat.size_m[1] / 2
        members.append(member(low_table, rng.uniform(-0.1, 0.1), table_at))
        members.append(member(seat, 0, sofa_at, yaw_rad=math.pi))
        rug_width, rug_depth = seat.size_m[0] + 0.4, 2.0
        members.append(self._rug_at(rug_width, rug_depth, table_at + 0.15))
        beside = seat.size_m[0] / 2 + 0.32
        end = int(rng.choice([-1, 1]))
        if rng.uniform() < 0.6:
            table = self.make("side_table")
            members.append(member(table, end * beside, sofa_at + 0.1))
            members.append(member(self.make("table_lamp"), end * beside, sofa_at + 0.1, table.size_m[2]))
        else:
            members.append(member(self.make("floor_lamp"), end * beside, sofa_at + 0.1))
        if rng.uniform() < 0.6:
            members.append(
                member(
                    self.make("armchair"),
                    -end * (seat.size_m[0] / 2 + 0.25),
                    table_at,
                    yaw_rad=-end * -math.pi / 2,
                )
            )
        if rng.uniform() < 0.5 * self.clutter + 0.3:
            members.append(member(self.make("small_plant"), 0.1, table_at, low_table.size_m[2]))
        return together(members)

    def _bed_between_lamps(self, kind: str) -> Arrangement:
        made = self.make(kind)
        members = [against_wall(made)]
        members.append(self._rug_at(made.size_m[0] + 1.0, 1.5, made.size_m[1] * 0.75))
        for end in (-1, 1) if kind == "bed" else (int(self.rng.choice([-1, 1])),):
            stand = self.make("side_table")
            x = end * (made.size_m[0] / 2 + 0.08 + stand.size_m[0] / 2)
            y = stand.size_m[1] / 2 + 0.04
            members.append(member(stand, x, y))
            members.append(member(self.make("table_lamp"), x, y, stand.size_m[2]))
        return together(members)

    def _workplace(self) -> Arrangement:
        desk, screen, seat = self.make("desk"), self.make("computer"), self.make("office_chair")
        base = against_wall(desk)
        # The user sits at the front of the desk and faces the wall; the screen faces the user.
        members = [
            base,
            member(
                screen,
                self.rng.uniform(-0.15, 0.15),
                base.footprint.y0 + desk.size_m[1] * 0.47,
                desk.size_m[2],
            ),
        ]
        members.append(
            member(
                seat,
                self.rng.uniform(-0.1, 0.1),
                base.footprint.y1 + seat.size_m[1] / 2 + 0.06,
                yaw_rad=math.pi,
            )
        )
        if self.rng.uniform() < 0.5:
            members.append(
                member(
                    self.make("table_lamp"), desk.size_m[0] * 0.38, base.footprint.y0 + 0.2, desk.size_m[2]
                )
            )
        return together(members)

    def _table_with_chairs(self) -> Arrangement:
        table = self.make("dining_table")
        width, depth, _ = table.size_m
        members = [member(table)]
        seat = self.make("dining_chair")
        reach = seat.size_m[1] / 2 + 0.05
        along = 2 if width > 1.3 else 1
        for end in (-1, 1):
            for k in range(along):
                x = (k - (along - 1) / 2) * width * 0.5
                yaw = (math.pi if end > 0 else 0.0) + self.rng.normal(0, 0.05)
                members.append(
                    member(
                        seat,
                        x + self.rng.normal(0, 0.02),
                        end * (depth / 2 + reach + self.rng.uniform(0, 0.08)),
                        yaw_rad=yaw,
                    )
                )
            if along == 1 or self.rng.uniform() < 0.4:
                yaw = end * math.pi / 2 + self.rng.normal(0, 0.05)
                members.append(
                    member(seat, end * (width / 2 + reach + self.rng.uniform(0, 0.06)), 0, yaw_rad=yaw)
                )
        if self.rng.uniform() < 0.7:
            members.append(member(self.make("small_plant"), 0, 0, table.size_m[2]))
        return together(members)

    def _rug_at(self, width: float, depth: float, y: float) -> Member:
        return member(_rug_piece(self.rng, width, depth, self.style), 0, y, blocks=False)

    def _rug(self, width: float, depth: float, *, spread: float = 0.15) -> None:
        made = together([self._rug_at(width, depth, 0.0)])
        self.floor.place_inside(self.rng, made, spread=spread, tries=6)

    def _toys(self, count: int) -> None:
        for _ in range(count):
            toy = self.make("toy")
            made = together([member(toy, yaw_rad=self.rng.uniform(0, 2 * math.pi))])
            self.floor.place_inside(self.rng, made, spread=0.47, tries=12)


def _rug_piece(rng: np.random.Generator, width: float, depth: float, style: Style) -> Piece:
    mat = box((width, depth, 0.009), bevel_m=0.004).with_uv_offset(*rng.uniform(0, 1, 2))
    return piece(BACKGROUND, [(mat, style.rug)])


ROOM_KINDS: Mapping[str, Callable[[Furnisher], None]] = {
    "living": Furnisher.living,
    "bedroom": Furnisher.bedroom,
    "bathroom": Furnisher.bathroom,
    "dining": Furnisher.dining,
    "office": Furnisher.office,
    "children": Furnisher.children,
}


def draw_room_kinds(rng: np.random.Generator, areas_m2: list[float]) -> list[str]:
    """A kind for each room: the first kinds once each, then repeats; bathrooms go to small rooms."""
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
