"""Rows of buildings around blocks, and what closes the ends of the streets."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tacos_worlds.kit.piece import Piece
from tacos_worlds.kit.rectangle import Rect
from tacos_worlds.street.city import CARRIAGEWAY_M, KERB_M, PAVEMENT_M, Town, building_line
from tacos_worlds.street.things.buildings import building, draw_house

_LOT_M = (10.0, 22.0)
_DEPTH_M = 12.0
_NEAR_M = 1.0


@dataclass(frozen=True)
class _Side:
    """A side of a block in the frame of its fronts: x along them seen from the street, -y to the street."""

    origin_m: tuple[float, float]  # of its left end
    yaw_quarters: int  # by which the frame is turned
    length_m: float  # from end to end [m]
    corner_left: bool  # true if that end stands at a street corner
    corner_right: bool


def row(
    rng: np.random.Generator, side: _Side, *, detailed: bool, tall_share: float, dark: bool
) -> list[Piece]:
    count = max(1, round(side.length_m / float(rng.uniform(13.0, 17.0))))
    share = rng.uniform(*_LOT_M, count)
    widths = share / share.sum() * side.length_m
    pieces, x = [], 0.0
    for number, width in enumerate(widths.tolist()):
        house = draw_house(rng, width, _DEPTH_M, tall=bool(rng.uniform() < tall_share))
        made = building(
            rng,
            house,
            open_left=side.corner_left and number == 0,
            open_right=side.corner_right and number == count - 1,
            detailed=detailed,
            dark=dark,
        )
        turned = made.moved(x, 0).turned(side.yaw_quarters * math.pi / 2)
        pieces.append(turned.moved(side.origin_m[0], side.origin_m[1], KERB_M))
        x += width
    return pieces


def inner_block(rng: np.random.Generator, block: Rect, *, dark: bool = False) -> list[Piece]:
    """Buildings on all four sides of a block; the long rows own the corners."""
    line = building_line(block)
    w, h = line.size
    sides = (
        _Side((line.x0, line.y0), 0, w, True, True),
        _Side((line.x1, line.y0 + _DEPTH_M), 1, h - 2 * _DEPTH_M, False, False),
        _Side((line.x1, line.y1), 2, w, True, True),
        _Side((line.x0, line.y1 - _DEPTH_M), 3, h - 2 * _DEPTH_M, False, False),
    )
    return [piece for side in sides for piece in row(rng, side, detailed=True, tall_share=0.0, dark=dark)]


def outer_block(rng: np.random.Generator, block: Rect, town: Town, *, dark: bool = False) -> list[Piece]:
    """Plain rows along those sides of an outer block that face streets, and a tower behind them."""
    line, extent = building_line(block), town.extent
    w, h = line.size
    faces = {
        0: block.y0 > extent.y0 + _NEAR_M,
        1: block.x1 < extent.x1 - _NEAR_M,
        2: block.y1 < extent.y1 - _NEAR_M,
        3: block.x0 > extent.x0 + _NEAR_M,
    }
    sides = {
        0: _Side((line.x0, line.y0), 0, w, faces[3], faces[1]),
        1: _Side(
            (line.x1, line.y0 + _DEPTH_M * faces[0]), 1, h - _DEPTH_M * (faces[0] + faces[2]), False, False
        ),
        2: _Side((line.x1, line.y1), 2, w, faces[1], faces[3]),
        3: _Side(
            (line.x0, line.y1 - _DEPTH_M * faces[2]), 3, h - _DEPTH_M * (faces[0] + faces[2]), False, False
        ),
    }
    pieces = [
        piece
        for number, side in sides.items()
        if faces[number]
        for piece in row(rng, side, detailed=False, tall_share=0.12, dark=dark)
    ]
    if min(w, h) > 4 * _DEPTH_M:
        house = draw_house(rng, 22.0, 18.0, tall=True)
        tower = building(rng, house, open_left=True, open_right=True, detailed=False, dark=dark)
        pieces.append(tower.moved(line.centre[0] - 11, line.centre[1] - 9, KERB_M))
    return pieces


def street_ends(rng: np.random.Generator, town: Town, *, dark: bool = False) -> list[Piece]:
    """A large building across each end of each street, where the view along it stops."""
    extent, width = town.extent, CARRIAGEWAY_M + 2 * PAVEMENT_M + 8.0
    gap = 4.0
    ends = [((x - width / 2, extent.y1 + gap), 0) for x in town.street_x_m]
    ends += [((x + width / 2, extent.y0 - gap), 2) for x in town.street_x_m]
    ends += [((extent.x0 - gap, y - width / 2), 1) for y in town.street_y_m]
    ends += [((extent.x1 + gap, y + width / 2), 3) for y in town.street_y_m]
    pieces = []
    for (x, y), quarters in ends:
        house = draw_house(rng, width, 14.0, tall=bool(rng.uniform() < 0.4))
        made = building(rng, house, open_left=True, open_right=True, detailed=False, dark=dark)
        pieces.append(made.turned(quarters * math.pi / 2).moved(x, y, 0.0))
    return pieces
