"""The plan of a town: streets that cross, and the blocks between them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from tacos_worlds.kit.piece import Piece
from tacos_worlds.kit.rectangle import Rect

LANE_M = 3.4
"""Width of a lane; there is one each way, and people drive on the right [m]."""
PARKING_M = 2.3
"""Width of the parking bays along both kerbs [m]."""
CARRIAGEWAY_M = 2 * (LANE_M + PARKING_M)
"""From kerb to kerb [m]."""
PAVEMENT_M = 3.6
"""From the kerb to the buildings [m]."""
CORNER_M = PAVEMENT_M
"""Radius of the kerb at street corners [m]."""
KERB_M = 0.12
"""Height of the pavement above the road [m]."""

_BLOCK_M = (62.0, 104.0)


@dataclass(frozen=True)
class Town:
    """Straight streets along x and y, all crossing each other."""

    street_y_m: tuple[float, ...]  # middle of each street that runs along x, rising [m]
    street_x_m: tuple[float, ...]  # middle of each street that runs along y, rising [m]
    reach_m: float  # how far the streets go on beyond the outermost crossings [m]

    @property
    def extent(self) -> Rect:
        return Rect(
            self.street_x_m[0] - self.reach_m,
            self.street_y_m[0] - self.reach_m,
            self.street_x_m[-1] + self.reach_m,
            self.street_y_m[-1] + self.reach_m,
        )

    @property
    def middle(self) -> Rect:
        """From the first to the last crossing, where the car drives."""
        return Rect(self.street_x_m[0], self.street_y_m[0], self.street_x_m[-1], self.street_y_m[-1])

    def inner_blocks(self) -> tuple[Rect, ...]:
        """The land between four streets, up to their kerbs."""
        return tuple(
            Rect(x0, y0, x1, y1).grown(-CARRIAGEWAY_M / 2)
            for x0, x1 in pairwise(self.street_x_m)
            for y0, y1 in pairwise(self.street_y_m)
        )

    def outer_blocks(self) -> tuple[Rect, ...]:
        """The land beyond the outermost streets, up to the kerbs and to the ends of the streets."""
        extent = self.extent
        xs = (extent.x0 - CARRIAGEWAY_M / 2, *self.street_x_m, extent.x1 + CARRIAGEWAY_M / 2)
        ys = (extent.y0 - CARRIAGEWAY_M / 2, *self.street_y_m, extent.y1 + CARRIAGEWAY_M / 2)
        columns, rows = len(xs) - 1, len(ys) - 1
        return tuple(
            Rect(xs[i], ys[j], xs[i + 1], ys[j + 1]).grown(-CARRIAGEWAY_M / 2)
            for i in range(columns)
            for j in range(rows)
            if i in (0, columns - 1) or j in (0, rows - 1)
        )


def draw_town(rng: np.random.Generator, *, blocks: int, reach_m: float) -> Town:
    """A random town around the origin. `blocks`: blocks between streets along each axis."""

    def positions() -> tuple[float, ...]:
        gaps = rng.uniform(*_BLOCK_M, blocks)
        at = np.concatenate([[0.0], np.cumsum(gaps)])
        return tuple((at - at[-1] / 2).tolist())

    return Town(positions(), positions(), reach_m)


@dataclass(frozen=True)
class Kerb:
    """The right-hand kerb of a stretch of street without crossings, in the direction of traffic.

    Its frame has x along the traffic, y to the left (over the road) and z up from the road.
    """

    start_m: tuple[float, float]  # (x, y) of its beginning [m]
    heading: int  # quarter turns from +x, counter-clockwise
    length_m: float  # between the rounded corners [m]
    inner: bool  # true if it lies between two crossings, where the car may drive

    def point(self, along_m: float, left_m: float) -> tuple[float, float]:
        """(x, y) of a place of this frame [m]."""
        cos, sin = ((1, 0), (0, 1), (-1, 0), (0, -1))[self.heading]
        x, y = self.start_m
        return x + cos * along_m - sin * left_m, y + sin * along_m + cos * left_m

    def place(self, piece: Piece, along_m: float, left_m: float, z_m: float = 0.0) -> Piece:
        x, y = self.point(along_m, left_m)
        return piece.turned(self.heading * math.pi / 2).moved(x, y, z_m)


def kerbs(town: Town) -> tuple[Kerb, ...]:
    """All kerbs of a town, two for every stretch of street."""
    half, found = CARRIAGEWAY_M / 2, []
    extent = town.extent
    for axis, lines, crossings, (first, last) in (
        (0, town.street_y_m, town.street_x_m, (extent.x0, extent.x1)),
        (1, town.street_x_m, town.street_y_m, (extent.y0, extent.y1)),
    ):
        ends = (first, *crossings, last)
        for line in lines:
            for number, (low, high) in enumerate(pairwise(ends)):
                inner = 0 < number < len(ends) - 2
                low, high = low + half + CORNER_M, high - half - CORNER_M
                for back in (False, True):
                    along, across = (high, line + half) if back else (low, line - half)
                    if axis == 1:
                        across = 2 * line - across
                    start = (along, across) if axis == 0 else (across, along)
                    found.append(Kerb(start, axis + 2 * back, high - low, inner))
    return tuple(found)


def building_line(block: Rect) -> Rect:
    """The land of a block behind its pavement."""
    return block.grown(-PAVEMENT_M)
