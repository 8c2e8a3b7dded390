"""Furniture that belongs together and is placed as one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from tacos_worlds.kit.piece import Piece
from tacos_worlds.kit.rectangle import Rect


@dataclass(frozen=True, eq=False)
class Member:
    """A piece in the frame of its arrangement."""

    piece: Piece  # the piece, already turned and moved
    footprint: Rect
    height_m: float  # its top above the floor [m]
    blocks: bool  # true if it takes floor: false for rugs and for things that stand on others

    @property
    def flat(self) -> bool:
        return not self.blocks and self.height_m < 0.03


@dataclass(frozen=True, eq=False)
class Arrangement:
    """Members around the origin; against a wall, the wall runs along x at y = 0."""

    members: tuple[Member, ...]

    def set_at(self, x_m: float, y_m: float, quarter_turns: int) -> Arrangement:
        yaw = quarter_turns * math.pi / 2
        return Arrangement(
            tuple(
                Member(
                    m.piece.turned(yaw).moved(x_m, y_m),
                    placed_rect(m.footprint, x_m, y_m, quarter_turns),
                    m.height_m,
                    m.blocks,
                )
                for m in self.members
            )
        )


def placed_rect(rect: Rect, x_m: float, y_m: float, quarter_turns: int) -> Rect:
    """A rectangle turned about the origin by quarters, then moved [m]."""
    for _ in range(quarter_turns % 4):
        rect = Rect(-rect.y1, rect.x0, -rect.y0, rect.x1)
    return Rect(rect.x0 + x_m, rect.y0 + y_m, rect.x1 + x_m, rect.y1 + y_m)


def member(
    thing: Piece,
    x_m: float = 0.0,
    y_m: float = 0.0,
    z_m: float = 0.0,
    *,
    yaw_rad: float = 0.0,
    blocks: bool | None = None,
) -> Member:
    """A piece turned, then moved; it blocks the floor unless it is raised off it or said otherwise."""
    made = thing.turned(yaw_rad).moved(x_m, y_m, z_m)
    low, high = made.bounds_m
    footprint = Rect(float(low[0]), float(low[1]), float(high[0]), float(high[1]))
    return Member(made, footprint, float(high[2]), z_m == 0.0 if blocks is None else blocks)


def against_wall(thing: Piece, *, gap_m: float = 0.03) -> Member:
    return member(thing, 0.0, thing.size_m[1] / 2 + gap_m)


def alone(thing: Piece, *, gap_m: float = 0.03) -> Arrangement:
    return Arrangement((against_wall(thing, gap_m=gap_m),))


def together(members: Sequence[Member]) -> Arrangement:
    return Arrangement(tuple(members))
