"""Things on tables, worktops and sideboards."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from tacos_worlds.indoor.furnishing.arrangement import Arrangement, Member, member
from tacos_worlds.indoor.furnishing.occupancy import RoomFloor
from tacos_worlds.indoor.things import reading, tableware, vessels
from tacos_worlds.kit.finishes import Style
from tacos_worlds.kit.piece import Builder, Piece, Top
from tacos_worlds.kit.rectangle import Rect

THINGS: Mapping[str, tuple[float, tuple[Builder, ...]]] = {
    "meal": (
        3.0, (vessels.bottle, vessels.fruit_bowl, vessels.vase, tableware.drinking_glass, reading.papers)
    ),
    "desk": (
        6.0, (reading.papers, reading.books, tableware.mug, reading.open_book, reading.papers, vessels.bottle)
    ),
    "low": (6.0, (reading.books, reading.remote, tableware.mug, reading.open_book, vessels.fruit_bowl)),
    "bedside": (7.0, (reading.alarm_clock, reading.books, tableware.drinking_glass, reading.open_book)),
    "counter": (
        9.0,
        (vessels.kettle, vessels.bottle, tableware.mug, vessels.fruit_bowl, vessels.bottle, tableware.mug),
    ),
    "board": (5.0, (vessels.vase, reading.books, vessels.fruit_bowl, reading.alarm_clock, reading.books)),
}  # fmt: skip
"""For each use of a top: how many things stand on a square metre of it at medium clutter, and which."""
_MOST = 7
_GAP_M = 0.015
_TRIES = 10
_LAID = 0.6
"""Share of the dining tables that are laid."""
_SETTING_M = 0.72
"""Along the edge of a table for each who eats there [m]."""


def lay_out(
    rng: np.random.Generator, floor: RoomFloor, style: Style, *, clutter: float, triangles: int
) -> None:
    """Put small things on every top of a furnished room, up to a number of triangles."""
    on_tops = [m for made in floor.placed for m in made.members]
    found: list[Member] = []
    for base in list(on_tops):
        for top in base.piece.tops:
            taken = [m.footprint for m in on_tops if _stands_on(m, top)]
            if top.use == "meal" and rng.uniform() < _LAID * min(1.0, 2 * clutter):
                found += _laid(rng, top, style, taken)
            found += _scattered(rng, top, style, taken, clutter)
    kept, spent = [], 0
    for made in found:
        spent += sum(len(mesh.triangles) for mesh, _ in made.piece.parts)
        if spent > triangles:
            break
        kept.append(made)
    if kept:
        floor.placed.append(Arrangement(tuple(kept)))


def _stands_on(m: Member, top: Top) -> bool:
    low = float(m.piece.bounds_m[0][2])
    return abs(low - top.height_m) < 0.03 and m.footprint.overlaps(top.rect)


def _scattered(
    rng: np.random.Generator, top: Top, style: Style, taken: list[Rect], clutter: float
) -> list[Member]:
    per_m2, builders = THINGS[top.use]
    width, depth = top.rect.size
    count = min(_MOST, int(rng.poisson(per_m2 * width * depth * 2 * clutter)))
    order = rng.permutation(len(builders))
    found = []
    for k in range(count):
        thing = builders[int(order[k % len(builders)])](rng, style)
        for _ in range(_TRIES):
            at = rng.uniform([top.rect.x0, top.rect.y0], [top.rect.x1, top.rect.y1])
            if made := _put(thing, top, at, float(rng.uniform(0, 2 * math.pi)), taken):
                found.append(made)
                break
    return found


def _laid(rng: np.random.Generator, top: Top, style: Style, taken: list[Rect]) -> list[Member]:
    """Plates and glasses along both long edges."""
    width, depth = top.rect.size
    x, y = top.rect.centre
    along = 0 if width >= depth else 1
    long, short = max(width, depth), min(width, depth)
    seats = max(1, int(long / _SETTING_M))
    dish, glass = tableware.plate(rng, style), tableware.drinking_glass(rng, style)
    found = []
    for side in (-1, 1):
        for seat in range(seats):
            off = ((seat + 0.5) / seats - 0.5) * long
            edge = side * (short / 2 - 0.15)
            yaw = (0.0 if side < 0 else math.pi) + (0.0 if along == 0 else -math.pi / 2)
            for thing, aside, inwards in ((dish, 0.0, 0.0), (glass, 0.12 * side, 0.2 * side)):
                at = np.array([off + aside, edge - inwards])
                place = np.array([x, y]) + (at if along == 0 else at[::-1])
                if made := _put(thing, top, place, yaw, taken):
                    found.append(made)
    return found


def _put(thing: Piece, top: Top, at_m: np.ndarray, yaw_rad: float, taken: list[Rect]) -> Member | None:
    """The thing at a place of a top, if it fits there; what is taken grows by it."""
    made = member(thing, float(at_m[0]), float(at_m[1]), top.height_m, yaw_rad=yaw_rad, blocks=False)
    if not top.rect.contains(made.footprint) or any(made.footprint.overlaps(t, _GAP_M) for t in taken):
        return None
    taken.append(made.footprint)
    return made
