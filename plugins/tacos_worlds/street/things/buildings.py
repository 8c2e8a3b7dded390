"""Town houses, shops and offices in a row."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from tacos_worlds.kit.finishes import Finish
from tacos_worlds.kit.mesh import Mesh, merged, shaded
from tacos_worlds.kit.piece import Piece
from tacos_worlds.kit.shapes.boxes import slab
from tacos_worlds.street.finishes import (
    FRONTS,
    GALVANISED,
    OFFICE_VARIANTS,
    ROOF_FELT,
    ROOF_TILES,
    SHOP_VARIANTS,
    STONE,
    blank,
    entrance,
    front,
)
from tacos_worlds.street.panels import panel
from tacos_worlds.street.textures.walls import CELLS
from tacos_worlds.street.things import fronts

GROUND_FLOOR_M = 3.9
_STEP_M = 7.0
_BAY_M = 3.2

_TINTS = ((1.0, 1.0, 1.0), (0.92, 0.95, 1.0), (1.0, 0.95, 0.86), (0.84, 0.84, 0.86), (0.95, 0.87, 0.80))
"""Houses of one kind differ in age and paint: factors of their reflectance."""
_LIT_SHARE = (0.32, 0.12)
"""Share of the windows with light behind them, in dwellings and offices [1]."""

Parts = list[tuple[Mesh, Finish]]


@dataclass(frozen=True)
class House:
    width_m: float  # x from 0 to the width
    depth_m: float  # y from 0, the street, to the depth
    floors: int
    floor_m: float  # height of each of them [m]
    kind: int  # index into `FRONTS`; -1 for an office
    shop: bool  # true if the ground floor holds shops
    pitched: bool  # true if it has a tiled roof with its ridge along the street
    tint: int = 0  # index into `_TINTS`

    @property
    def eaves_m(self) -> float:
        return GROUND_FLOOR_M + self.floors * self.floor_m


def draw_house(rng: np.random.Generator, width_m: float, depth_m: float, *, tall: bool = False) -> House:
    office = tall or rng.uniform() < 0.12
    return House(
        width_m=width_m,
        depth_m=depth_m,
        floors=int(rng.integers(9, 22) if tall else rng.integers(2, 6)),
        floor_m=float(rng.uniform(2.9, 3.4)),
        kind=-1 if office else int(rng.integers(len(FRONTS))),
        shop=bool(rng.uniform() < 0.45),
        pitched=bool(not office and rng.uniform() < 0.5),
        tint=int(rng.integers(len(_TINTS))),
    )


def building(
    rng: np.random.Generator,
    house: House,
    *,
    open_left: bool,
    open_right: bool,
    detailed: bool,
    dark: bool = False,
) -> Piece:
    """A building whose front lies along x at y = 0 and faces -y.

    - `open_left`, `open_right`: true if the side at x = 0, or at the width, faces a street.
    - `detailed`: with cornices, bay windows, balconies and what stands on roofs.
    - `dark`: with lights in its windows.
    """
    parts: Parts = []
    w, d = house.width_m, house.depth_m
    step_m = _STEP_M if detailed else math.inf
    variant = int(rng.integers(SHOP_VARIANTS))
    first = int(rng.integers(CELLS))
    finish = _upper_finish(rng, house)
    walls = [(np.array([0.0, 0, 0]), np.array([1.0, 0, 0]), w)]
    for is_open, origin, along in (
        (open_left, np.array([0.0, d, 0]), np.array([0.0, -1, 0])),
        (open_right, np.array([w, 0.0, 0]), np.array([0.0, 1, 0])),
    ):
        if is_open:
            walls.append((origin, along, d))
        else:
            parts.append(_blank_wall(house, origin, along, d, step_m))
    parts.append(_blank_wall(house, np.array([w, d, 0.0]), np.array([-1.0, 0, 0]), w, step_m))
    for origin, along, length in walls:
        parts += _front(house, origin, along, length, first, variant, finish, step_m)
        if dark:
            parts += _lights(rng, house, origin, along, length, detailed)
    parts += _roof(house, detailed)
    if detailed:
        parts += _ornaments(rng, house, open_left, open_right)
        parts += _relief(rng, house, first, finish, dark)
    return Piece("building", tuple(parts))


def _upper_finish(rng: np.random.Generator, house: House) -> Finish:
    if house.kind < 0:
        return Finish("office", variant=int(rng.integers(OFFICE_VARIANTS)), roughness=0.95)
    return _aged(front(house.kind), house)


def _aged(finish: Finish, house: House) -> Finish:
    return replace(finish, tint=_TINTS[house.tint])


def _bays(length_m: float) -> int:
    return max(1, round(length_m / _BAY_M))


def _lights(
    rng: np.random.Generator, house: House, origin: np.ndarray, along: np.ndarray, length_m: float, near: bool
) -> Parts:
    bays = _bays(length_m)
    share = _LIT_SHARE[house.kind < 0] * float(rng.uniform(0.5, 1.4))
    found = fronts.lit_windows(
        rng, origin, along, length_m / bays, bays, GROUND_FLOOR_M, house.floors, house.floor_m,
        share=share, panes=near,
    )  # fmt: skip
    if near and (house.shop or house.kind < 0):
        found += fronts.lit_shops(rng, origin, along, length_m / bays, bays)
    return found


def _relief(rng: np.random.Generator, house: House, first: int, finish: Finish, dark: bool) -> Parts:
    """Relief of the front: bay windows or balconies, awnings, dormers, a downpipe."""
    bays, parts = _bays(house.width_m), [fronts.downpipe(0.05, house.eaves_m)]
    shape = (bays, house.width_m, GROUND_FLOOR_M, house.floors, house.floor_m)
    way = float(rng.uniform())
    if house.kind >= 0 and house.floors >= 3:
        if way < 0.3:
            parts += fronts.balconies(*shape)
        elif way < 0.6 and not dark:  # lit windows lie flat on the wall, behind bays
            parts += fronts.bay_windows(*shape, first, finish)
    if house.shop and house.kind >= 0 and rng.uniform() < 0.6:
        parts += fronts.awnings(rng, house.width_m)
    if house.pitched and rng.uniform() < 0.6:
        parts += fronts.dormers(rng, house.width_m, house.depth_m, house.eaves_m, finish)
    return parts


def _front(
    house: House,
    origin: np.ndarray,
    along: np.ndarray,
    length_m: float,
    first: int,
    variant: int,
    finish: Finish,
    step_m: float,
) -> Parts:
    """A wall to the street: ground floor and upper floors, in whole bays."""
    bays = _bays(length_m)
    up = np.array([0.0, 0, 1])
    shop = house.shop or house.kind < 0
    low = Finish("shops", variant=variant, roughness=0.95) if shop else _aged(entrance(house.kind), house)
    upper_origin = origin + GROUND_FLOOR_M * up
    return [
        (
            panel(
                origin,
                along * length_m,
                up * GROUND_FLOOR_M,
                u=(2 * (first // 2), 2 * (first // 2) + bays),
                v=(0.0, CELLS),
                step_m=step_m,
            ),
            low,
        ),
        (
            panel(
                upper_origin,
                along * length_m,
                up * house.floors * house.floor_m,
                u=(first, first + bays),
                v=(0.0, house.floors),
                step_m=step_m,
            ),
            finish,
        ),
    ]


def _blank_wall(
    house: House, origin: np.ndarray, along: np.ndarray, length_m: float, step_m: float
) -> tuple[Mesh, Finish]:
    cells = house.eaves_m / _BAY_M
    wall = panel(
        origin,
        along * length_m,
        (0, 0, house.eaves_m),
        u=(0, length_m / _BAY_M),
        v=(0, cells),
        step_m=2 * step_m,
    )
    return wall, _aged(blank(house.kind if house.kind >= 0 else len(FRONTS) - 1), house)


def _roof(house: House, detailed: bool) -> Parts:
    w, d, z = house.width_m, house.depth_m, house.eaves_m
    if not house.pitched:
        roof = panel((0, 0, z - 0.02), (w, 0, 0), (0, d, 0), step_m=2 * _STEP_M)
        return [(roof, ROOF_FELT)]
    rise, over = 0.38 * d, 0.35
    ridge = z + rise
    drop = over * rise / (d / 2)
    slope = np.array([0, d / 2 + over, rise + drop])
    front_side = panel((0, -over, z - drop), (w, 0, 0), slope)
    back_side = panel((w, d + over, z - drop), (-w, 0, 0), slope * [1, -1, 1])
    gables = shaded(
        [[0, 0, z], [0, d / 2, ridge], [0, d, z], [w, 0, z], [w, d, z], [w, d / 2, ridge]],
        [[0, 1, 2], [3, 4, 5]],
    )
    tiles = merged([front_side, back_side])
    return [(tiles, ROOF_TILES), (gables, _aged(blank(max(house.kind, 0)), house))]


def _ornaments(rng: np.random.Generator, house: House, open_left: bool, open_right: bool) -> Parts:
    w, d, z = house.width_m, house.depth_m, house.eaves_m
    stone: list[Mesh] = []
    bands = [(GROUND_FLOOR_M - 0.12, 0.22, 0.14)]
    bands += [(z - 0.45, 0.5, 0.32)] if not house.pitched else [(z - 0.3, 0.22, 0.2)]
    for at, high, out in bands:
        stone.append(slab((w, out, high), (w / 2, -out / 2, at)))
        for is_open, x in ((open_left, -out / 2), (open_right, w + out / 2)):
            if is_open:
                stone.append(slab((out, d, high), (x, d / 2, at)))
    parts: Parts = [(merged(stone), STONE)]
    if not house.pitched:
        parts.append((merged(list(_on_roof(rng, w, d, z))), GALVANISED))
    else:
        x = float(rng.uniform(0.15, 0.85)) * w
        ridge = z + 0.38 * d
        parts.append((slab((0.9, 0.6, 1.6), (x, d / 2, ridge - 0.5)), blank(0)))
    return parts


def _on_roof(rng: np.random.Generator, w: float, d: float, z: float) -> Iterator[Mesh]:
    for _ in range(int(rng.integers(1, 4))):
        size = (float(rng.uniform(1.0, 3.0)), float(rng.uniform(1.0, 2.5)), float(rng.uniform(0.8, 2.6)))
        yield slab(size, (float(rng.uniform(2, w - 2)), float(rng.uniform(d / 2, d - 2)), z))
