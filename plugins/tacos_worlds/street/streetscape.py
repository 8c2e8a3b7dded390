"""Everything that stands in a town."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tacos_worlds.kit.piece import Piece
from tacos_worlds.kit.rectangle import Rect
from tacos_worlds.street.city import CARRIAGEWAY_M, KERB_M, PARKING_M, Kerb, Town, building_line, kerbs
from tacos_worlds.street.frontage import inner_block, outer_block, street_ends
from tacos_worlds.street.ground import pavement, roads, yard
from tacos_worlds.street.things.footbridge import STAIRS_M, WIDTH_M, footbridge
from tacos_worlds.street.things.furniture import (
    advertisement,
    bench,
    bollard,
    lamp_post,
    litter_bin,
    planter,
    shelter,
    sign,
    street_name,
    traffic_light,
)
from tacos_worlds.street.things.trees import draw_tree, shrub
from tacos_worlds.street.things.vehicles import draw_car

FAR_DETAIL = 0.25
"""Light detail of what the car never comes near."""
CLEAR_M = 9.0
"""Nothing parks this close to the ends of a kerb, where crossings are [m]."""
_LOTS_M = 6.2
"""Length of a parking lot [m]."""
_FOOTBRIDGES = 2


@dataclass(frozen=True, eq=False)
class PlacedPiece:
    """A piece at its place, how finely the light on it has to be known, and whether it moves."""

    piece: Piece
    light_detail: float = 1.0
    moves: bool = False


def furnish_town(
    rng: np.random.Generator, town: Town, *, greenery: float, parked_share: float, dark: bool = False
) -> list[PlacedPiece]:
    """All that stands still in a town.

    - `greenery`: how many streets are lined with trees [1].
    - `parked_share`: share of the parking lots that are taken [1].
    - `dark`: true if lamps and windows are lit.
    """
    block_rng, kerb_rng, park_rng = rng.spawn(3)
    placed = [PlacedPiece(piece) for piece in roads(town)]
    inner = town.inner_blocks()
    park = int(park_rng.integers(len(inner))) if len(inner) > 1 else -1
    for number, (block, stream) in enumerate(zip(inner, block_rng.spawn(len(inner)), strict=True)):
        placed += [
            PlacedPiece(pavement(block)),
            PlacedPiece(yard(block), 1.0 if number == park else FAR_DETAIL),
        ]
        pieces = _park(park_rng, block) if number == park else inner_block(stream, block, dark=dark)
        placed += [PlacedPiece(piece) for piece in pieces]
    for block in town.outer_blocks():
        placed += [PlacedPiece(piece, FAR_DETAIL) for piece in (pavement(block), yard(block))]
        placed += [PlacedPiece(piece, FAR_DETAIL) for piece in outer_block(block_rng, block, town, dark=dark)]
    placed += [PlacedPiece(piece, FAR_DETAIL) for piece in street_ends(block_rng, town, dark=dark)]

    all_kerbs = kerbs(town)
    inner_kerbs = [k for k in all_kerbs if k.inner and k.length_m > 40]
    bridged = set(kerb_rng.choice(len(inner_kerbs) // 2, _FOOTBRIDGES, replace=False).tolist())
    bridges = [inner_kerbs[2 * number] for number in sorted(bridged)]
    bridges_m = [_middle(kerb) for kerb in bridges]
    placed += [PlacedPiece(kerb.place(footbridge(), kerb.length_m / 2, 0.0)) for kerb in bridges]
    for kerb, stream in zip(all_kerbs, kerb_rng.spawn(len(all_kerbs)), strict=True):
        under_bridge = any(np.linalg.norm(_middle(kerb) - at) < CARRIAGEWAY_M + 1 for at in bridges_m)
        if kerb.inner:
            placed += [
                PlacedPiece(p) for p in _line_kerb(stream, kerb, under_bridge, greenery, parked_share, dark)
            ]
        else:
            placed += [PlacedPiece(p, FAR_DETAIL) for p in _line_far_kerb(stream, kerb)]
    return placed


def triangles_of(placed: Sequence[PlacedPiece]) -> int:
    return sum(len(mesh.triangles) for thing in placed for mesh, _ in thing.piece.parts)


def _middle(kerb: Kerb) -> np.ndarray:
    x, y = ((1, 0), (0, 1), (-1, 0), (0, -1))[kerb.heading]
    return np.array(kerb.start_m) + kerb.length_m / 2 * np.array([x, y])


def _park(rng: np.random.Generator, block: Rect) -> list[Piece]:
    line, pieces = building_line(block), []
    columns, rows = (max(2, round(edge / 16.0)) for edge in line.size)
    for i in range(columns):
        for j in range(rows):
            x = line.x0 + (i + rng.uniform(0.25, 0.75)) * line.size[0] / columns
            y = line.y0 + (j + rng.uniform(0.25, 0.75)) * line.size[1] / rows
            thing = draw_tree(rng) if rng.uniform() < 0.7 else shrub(rng, float(rng.uniform(1.5, 3)))
            pieces.append(thing.moved(x, y, KERB_M))
    return pieces


def _line_kerb(
    rng: np.random.Generator,
    kerb: Kerb,
    under_bridge: bool,
    greenery: float,
    parked_share: float,
    dark: bool,
) -> list[Piece]:
    """Furniture along a kerb, and the cars that park at it."""
    length, pieces = kerb.length_m, []
    half = WIDTH_M / 2 + STAIRS_M + 1.0
    keep_clear = (length / 2 - half, length / 2 + half) if under_bridge else (length, length)

    def free(along_m: float, reach_m: float) -> bool:
        return along_m + reach_m < keep_clear[0] or along_m - reach_m > keep_clear[1]

    def put(piece: Piece, along_m: float, left_m: float) -> None:
        pieces.append(kerb.place(piece, along_m, left_m, KERB_M))

    signals = rng.uniform() < 0.5
    put(traffic_light(rng, glows=dark) if signals else sign(rng), length - 2.2, -0.5)
    put(street_name(rng), length - 0.6, -0.9)
    for along in np.arange(5.0, length - 6, 30.0) + rng.uniform(0, 4):
        if free(along, 1.0):
            put(lamp_post(rng, lit=dark), along, -0.5)
    if rng.uniform() < greenery:
        for along in np.arange(11.0, length - 8, float(rng.uniform(13.0, 18.0))):
            if free(along, 4.0):
                put(draw_tree(rng), along + rng.uniform(-1, 1), -1.0)
    things = (litter_bin, planter, bench, bollard, sign, litter_bin, bollard, advertisement)
    for along in np.arange(15.0, length - 8, 9.0):
        if rng.uniform() < 0.5 and free(along, 1.5):
            thing = things[int(rng.integers(len(things)))]
            put(thing(rng), along + rng.uniform(-0.5, 0.5), -1.1 if thing is advertisement else -0.6)
    lots = int((length - 2 * CLEAR_M) // _LOTS_M)
    with_shelter = lots > 4 and rng.uniform() < 0.25 and not under_bridge
    for lot in range(lots):
        along = CLEAR_M + (lot + 0.5) * _LOTS_M
        if with_shelter and lot in (1, 2):
            if lot == 1:
                put(shelter(rng), along, -2.4)
            continue
        if rng.uniform() < parked_share:
            car = draw_car(rng)
            left = PARKING_M / 2 + rng.normal(0, 0.06)
            pieces.append(kerb.place(car, along + rng.uniform(-0.3, 0.3), left))
    return pieces


def _line_far_kerb(rng: np.random.Generator, kerb: Kerb) -> list[Piece]:
    """The odd parked car and tree where the car never comes."""
    pieces = []
    for along in np.arange(14.0, kerb.length_m - 8, 45.0):
        if rng.uniform() < 0.2:
            pieces.append(kerb.place(draw_car(rng, far=True), along + rng.uniform(-3, 3), PARKING_M / 2))
        if rng.uniform() < 0.3:
            pieces.append(kerb.place(draw_tree(rng, far=True), along + 8.0, -1.0, KERB_M))
    return pieces
