"""Books, papers, remote controls, alarm clocks."""

from __future__ import annotations

import math

import numpy as np

from tacos_worlds.kit.colours import linear, muted
from tacos_worlds.kit.finishes import BLACK_PLASTIC, DARK_GLASS, GREY_PLASTIC, Finish, Style
from tacos_worlds.kit.mesh import Mesh, merged, rotation_x
from tacos_worlds.kit.piece import Piece, piece
from tacos_worlds.kit.shapes import box, disc_stack, slab

_PAGES = Finish("", (0.78, 0.75, 0.68), roughness=0.95)
_INK = Finish("", (0.16, 0.16, 0.17), roughness=0.95)


def books(rng: np.random.Generator, style: Style) -> Piece:
    parts: list[tuple[Mesh, Finish]] = []
    pages: list[Mesh] = []
    low = 0.0
    for _ in range(int(rng.integers(1, 5))):
        wide, long, thick = rng.uniform(0.13, 0.2), rng.uniform(0.19, 0.27), rng.uniform(0.014, 0.04)
        yaw = rng.normal(0, 0.15)
        cover = Finish("", linear(muted(rng, saturation=(0.1, 0.75), value=(0.2, 0.85))), roughness=0.6)
        boards = [slab((wide, long, 0.003), (0, 0, z)) for z in (0.0, thick - 0.003)]
        spine = slab((0.004, long, thick), (-wide / 2, 0, 0))
        parts.append((merged([*boards, spine]).turned(yaw).moved(0, 0, low), cover))
        pages.append(
            slab((wide - 0.008, long - 0.008, thick - 0.006), (0.0, 0, 0.003)).turned(yaw).moved(0, 0, low)
        )
        low += thick
    return piece("book", [*parts, (merged(pages), _PAGES)])


def open_book(rng: np.random.Generator, style: Style) -> Piece:
    halves = [slab((0.14, 0.21, 0.012), (side * 0.07, 0, 0)) for side in (-1, 1)]
    return piece("book", [(merged(halves), _PAGES), (_lines(0.11, 0.17, (-0.07, 0.07), 0.012), _INK)])


def papers(rng: np.random.Generator, style: Style) -> Piece:
    high, sheets = 0.0, []
    for _ in range(int(rng.integers(1, 4))):
        thick, yaw = rng.uniform(0.002, 0.006), rng.normal(0, 0.2)
        sheets.append(slab((0.21, 0.297, thick), (0, 0, high)).turned(yaw))
        high += thick
    ink = _lines(0.16, 0.24, (0.0,), 0.0).turned(yaw).moved(0, 0, high)
    return piece("paper", [(merged(sheets), Finish("", (0.82, 0.82, 0.81), roughness=0.95)), (ink, _INK)])


def remote(rng: np.random.Generator, style: Style) -> Piece:
    keys = [
        slab((0.007, 0.007, 0.002), (x, y, 0.018)) for x in (-0.012, 0.0, 0.012) for y in (-0.05, -0.02, 0.01)
    ]
    return piece(
        "remote", [(box((0.045, 0.17, 0.018), bevel_m=0.005), BLACK_PLASTIC), (merged(keys), GREY_PLASTIC)]
    )


def alarm_clock(rng: np.random.Generator, style: Style) -> Piece:
    upright = rotation_x(-math.pi / 2)
    case = (
        disc_stack([(0.045, -0.03), (0.05, -0.025), (0.05, 0.0)], sides=14)
        .rotated(upright)
        .moved(0, 0.0, 0.058)
    )
    face = disc_stack([(0.043, 0.0), (0.043, 0.002)], sides=14).rotated(upright).moved(0, 0.0, 0.058)
    hands = []
    for length in (0.022, 0.034):
        turn = rng.uniform(0, 2 * math.pi)
        hand = slab((0.004, 0.002, length), (0, 0.003, 0.0))
        cos, sin = math.cos(turn), math.sin(turn)
        hands.append(hand.rotated(np.array([[cos, 0, sin], [0, 1, 0], [-sin, 0, cos]])).moved(0, 0, 0.058))
    feet = [slab((0.012, 0.02, 0.015), (x, -0.01, 0)) for x in (-0.03, 0.03)]
    paint = Finish("", linear(muted(rng, saturation=(0.1, 0.6), value=(0.3, 0.9))), roughness=0.4)
    dial = Finish("", (0.82, 0.81, 0.78), roughness=0.8)
    return piece("clock", [(merged([case, *feet]), paint), (face, dial), (merged(hands), DARK_GLASS)])


def _lines(width: float, length: float, columns: tuple[float, ...], high: float) -> Mesh:
    rows = np.linspace(-length / 2, length / 2, 9)
    return merged([slab((width, 0.006, 0.0008), (x, float(y), high)) for x in columns for y in rows])
