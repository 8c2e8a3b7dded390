"""Town houses, shops and offices in a row."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tacos_worlds.indoor.finishes import Finish
from tacos_worlds.indoor.mesh import Mesh, merged, shaded
from tacos_worlds.indoor.piece import Piece
from tacos_worlds.indoor.shapes.boxes import slab
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

GROUND_FLOOR_M = 3.9
_STEP_M = 7.0
_BAY_M = 3.2

_CANVAS = ((0.35, 0.05, 0.05), (0.05, 0.16, 0.09), (0.55, 0.50, 0.38), (0.06, 0.11, 0.25))

Parts = list[tuple[Mesh, Finish]]


@dataclass(frozen=True)
class House:
    """What a building of a row is like.

    Parameters
    ----------
    width_m, depth_m
        Its footprint: x from 0 to the width, y from 0 (the street) to the depth [m].
    floors
        Upper floors.
    floor_m
        Height of each of them [m].
    kind
        Index into `FRONTS`; -1 for an office.
    shop
        Whether the ground floor holds shops.
    pitched
        Whether it has a tiled roof with its ridge along the street.
    """

    width_m: float
    depth_m: float
    floors: int
    floor_m: float
    kind: int
    shop: bool
    pitched: bool

    @property
    def eaves_m(self) -> float:
        """Height of the walls [m]."""
        return GROUND_FLOOR_M + self.floors * self.floor_m


def draw_house(rng: np.random.Generator, width_m: float, depth_m: float, *, tall: bool = False) -> House:
    """A random building of a given footprint."""
    office = tall or rng.uniform() < 0.12
    return House(
        width_m=width_m,
        depth_m=depth_m,
        floors=int(rng.integers(9, 22) if tall else rng.integers(2, 6)),
        floor_m=float(rng.uniform(2.9, 3.4)),
        kind=-1 if office else int(rng.integers(len(FRONTS))),
        shop=bool(rng.uniform() < 0.45),
        pitched=bool(not office and rng.uniform() < 0.5),
    )


def building(
    rng: np.random.Generator, house: House, *, open_left: bool, open_right: bool, detailed: bool
) -> Piece:
    """A building whose front lies along x at y = 0 and faces -y.

    Parameters
    ----------
    open_left, open_right
        Whether the side at x = 0, or at the width, faces a street.
    detailed
        With cornices, balconies and what stands on roofs.
    """
    parts: Parts = []
    w, d = house.width_m, house.depth_m
    step_m = _STEP_M if detailed else math.inf
    variant = int(rng.integers(SHOP_VARIANTS))
    parts += _front(rng, house, np.array([0.0, 0, 0]), np.array([1.0, 0, 0]), w, variant, step_m)
    for is_open, origin, along in (
        (open_left, np.array([0.0, d, 0]), np.array([0.0, -1, 0])),
        (open_right, np.array([w, 0.0, 0]), np.array([0.0, 1, 0])),
    ):
        if is_open:
            parts += _front(rng, house, origin, along, d, variant, step_m)
        else:
            parts.append(_blank_wall(house, origin, along, d, step_m))
    parts.append(_blank_wall(house, np.array([w, d, 0.0]), np.array([-1.0, 0, 0]), w, step_m))
    parts += _roof(house, detailed)
    if detailed:
        parts += _ornaments(rng, house, open_left, open_right)
    return Piece("building", tuple(parts))


def _upper_finish(rng: np.random.Generator, house: House) -> Finish:
    if house.kind < 0:
        return Finish("office", variant=int(rng.integers(OFFICE_VARIANTS)), roughness=0.95)
    return front(house.kind)


def _front(
    rng: np.random.Generator,
    house: House,
    origin: np.ndarray,
    along: np.ndarray,
    length_m: float,
    variant: int,
    step_m: float,
) -> Parts:
    """A wall to the street: ground floor and upper floors, in whole bays."""
    bays = max(1, round(length_m / _BAY_M))
    first = int(rng.integers(CELLS))
    up = np.array([0.0, 0, 1])
    shop = house.shop or house.kind < 0
    low = Finish("shops", variant=variant, roughness=0.95) if shop else entrance(house.kind)
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
            _upper_finish(rng, house),
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
    return wall, blank(house.kind if house.kind >= 0 else len(FRONTS) - 1)


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
    return [(tiles, ROOF_TILES), (gables, blank(max(house.kind, 0)))]


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
    if house.kind >= 0 and house.floors >= 3 and rng.uniform() < 0.35:
        parts += _balconies(house)
    if house.shop and house.kind >= 0 and rng.uniform() < 0.6:
        parts += _awnings(rng, house)
    return parts


def _on_roof(rng: np.random.Generator, w: float, d: float, z: float) -> Iterator[Mesh]:
    """Lift heads and ventilation."""
    for _ in range(int(rng.integers(1, 4))):
        size = (float(rng.uniform(1.0, 3.0)), float(rng.uniform(1.0, 2.5)), float(rng.uniform(0.8, 2.6)))
        yield slab(size, (float(rng.uniform(2, w - 2)), float(rng.uniform(d / 2, d - 2)), z))


def _balconies(house: House) -> Parts:
    """A balcony at every other bay of the upper floors but the highest."""
    bays = max(1, round(house.width_m / _BAY_M))
    bay_m = house.width_m / bays
    slabs, rails = [], []
    for floor in range(1, house.floors - 1):
        z = GROUND_FLOOR_M + floor * house.floor_m + 0.15
        for bay in range(0, bays, 2):
            x = (bay + 0.5) * bay_m
            slabs.append(slab((0.8 * bay_m, 1.0, 0.14), (x, -0.5, z)))
            rails.append(slab((0.8 * bay_m, 0.04, 0.9), (x, -0.98, z + 0.14)))
    return [(merged(slabs), STONE), (merged(rails), Finish("metal", (0.10, 0.11, 0.12), roughness=0.85))]


def _awnings(rng: np.random.Generator, house: House) -> Parts:
    """Sloping canvas over the windows of the shops."""
    colour = _CANVAS[int(rng.integers(len(_CANVAS)))]
    pieces = []
    for x in np.arange(0.4, house.width_m - 3.0, 6.4):
        width = min(5.6, house.width_m - x - 0.4)
        high, low, out = 2.95, 2.45, 1.3
        top = panel((x, -out, low), (width, 0, 0), (0, out, high - low))
        under = panel((x + width, -out, low), (-width, 0, 0), (0, out, high - low))
        hem = panel((x, -out, low - 0.22), (width, 0, 0), (0, 0, 0.22))
        pieces += [top, under, hem]
    return [(merged(pieces), Finish("metal", colour, roughness=0.95))] if pieces else []
