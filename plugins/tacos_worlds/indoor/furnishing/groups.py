"""Pieces that belong together: a sofa opposite a television, a bed between lamps, chairs around a table."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from tacos_worlds.indoor.furnishing.arrangement import Arrangement, Member, against_wall, member, together
from tacos_worlds.kit.finishes import Style
from tacos_worlds.kit.piece import BACKGROUND, Piece, piece
from tacos_worlds.kit.shapes import box

Make = Callable[[str], Piece]
"""Makes one piece of a kind of the catalogue."""


def on_top(rng: np.random.Generator, support: Piece, thing: Piece) -> Arrangement:
    base = against_wall(support)
    slack = max(support.size_m[0] - thing.size_m[0], 0.0) / 2
    aside = rng.uniform(-slack, slack) * (0.2 if thing.class_name == "computer_tv" else 0.85)
    return together(
        [base, member(thing, aside, base.footprint.y0 + support.size_m[1] / 2, support.size_m[2])]
    )


def television_corner(rng: np.random.Generator, make: Make, style: Style) -> Arrangement:
    """Television on a sideboard, and opposite, over a rug with a low table, a sofa with a lamp beside it."""
    stand, screen = against_wall(make("sideboard")), make("television")
    seat, low_table = make("sofa"), make("coffee_table")
    table_at = stand.footprint.y1 + rng.uniform(1.0, 1.3) + low_table.size_m[1] / 2
    sofa_at = table_at + low_table.size_m[1] / 2 + rng.uniform(0.38, 0.5) + seat.size_m[1] / 2
    members = [
        stand,
        member(screen, 0, stand.footprint.y1 - 0.2, stand.height_m),
        member(low_table, rng.uniform(-0.1, 0.1), table_at),
        member(seat, 0, sofa_at, yaw_rad=math.pi),
        rug(rng, style, seat.size_m[0] + 0.5, 2.2, y_m=table_at + 0.15),
        member(make("small_plant"), 0.1, table_at, low_table.size_m[2]),
    ]
    end = int(rng.choice([-1, 1]))
    if rng.uniform() < 0.6:
        table = make("side_table")
        beside = end * (seat.size_m[0] / 2 + table.size_m[0] / 2 + 0.06)
        members.append(member(table, beside, sofa_at + 0.1))
        members.append(member(make("table_lamp"), beside, sofa_at + 0.1, table.size_m[2]))
    else:
        lamp = make("floor_lamp")
        members.append(member(lamp, end * (seat.size_m[0] / 2 + lamp.size_m[0] / 2 + 0.06), sofa_at + 0.1))
    if rng.uniform() < 0.6:
        chair = make("armchair")
        aside = -end * (max(seat.size_m[0], low_table.size_m[0]) / 2 + 0.35 + chair.size_m[1] / 2 - 0.2)
        members.append(member(chair, aside, table_at - 0.1, yaw_rad=-end * math.pi / 2))
    return together(members)


def reading_corner(rng: np.random.Generator, make: Make, style: Style) -> Arrangement:
    seat, table, lamp = make("armchair"), make("side_table"), make("floor_lamp")
    members = [against_wall(seat, gap_m=0.1)]
    end = int(rng.choice([-1, 1]))
    beside = end * (seat.size_m[0] / 2 + table.size_m[0] / 2 + 0.08)
    members.append(member(table, beside, table.size_m[1] / 2 + 0.25))
    members.append(
        member(lamp, -end * (seat.size_m[0] / 2 + lamp.size_m[0] / 2 + 0.06), lamp.size_m[1] / 2 + 0.08)
    )
    members.append(rug(rng, style, 1.6, 1.1, y_m=0.75))
    return together(members)


def sofa_at_wall(rng: np.random.Generator, make: Make, style: Style) -> Arrangement:
    seat, table = against_wall(make("sofa"), gap_m=0.06), make("coffee_table")
    at = seat.footprint.y1 + 0.42 + table.size_m[1] / 2
    return together([seat, member(table, 0, at), rug(rng, style, 2.2, 1.6, y_m=at - 0.15)])


def bed_between_lamps(rng: np.random.Generator, make: Make, style: Style, kind: str) -> Arrangement:
    made = make(kind)
    members = [against_wall(made), rug(rng, style, made.size_m[0] + 1.0, 1.5, y_m=made.size_m[1] * 0.75)]
    for end in (-1, 1) if kind == "bed" else (int(rng.choice([-1, 1])),):
        stand = make("side_table")
        x = end * (made.size_m[0] / 2 + 0.08 + stand.size_m[0] / 2)
        y = stand.size_m[1] / 2 + 0.04
        members += [member(stand, x, y), member(make("table_lamp"), x, y, stand.size_m[2])]
    return together(members)


def workplace(rng: np.random.Generator, make: Make, style: Style) -> Arrangement:
    desk, screen, seat = make("desk"), make("computer"), make("office_chair")
    base = against_wall(desk)
    middle = base.footprint.y0 + desk.size_m[1] * 0.47
    front = base.footprint.y1 + seat.size_m[1] / 2 + 0.06
    members = [
        base,
        member(screen, rng.uniform(-0.15, 0.15), middle, desk.size_m[2]),
        member(seat, rng.uniform(-0.1, 0.1), front, yaw_rad=math.pi),
    ]
    if rng.uniform() < 0.5:
        lamp = make("table_lamp")
        aside = desk.size_m[0] / 2 - lamp.size_m[0] / 2 - 0.02
        if aside > screen.size_m[0] / 2 + 0.15 + lamp.size_m[0] / 2:
            back = base.footprint.y0 + lamp.size_m[1] / 2 + 0.03
            members.append(member(lamp, -aside, back, desk.size_m[2]))
    return together(members)


def table_with_chairs(rng: np.random.Generator, make: Make, style: Style) -> Arrangement:
    table, seat = make("dining_table"), make("dining_chair")
    width, depth, height = table.size_m
    members = [
        member(table),
        rug(rng, style, width + 1.6, depth + 1.6),
        member(make("small_plant"), 0, 0, height),
    ]
    reach = seat.size_m[1] / 2 + 0.05
    along = 2 if width > 1.3 else 1
    for end in (-1, 1):
        for k in range(along):
            x = (k - (along - 1) / 2) * width * 0.5 + rng.normal(0, 0.02)
            yaw = (math.pi if end > 0 else 0.0) + rng.normal(0, 0.05)
            members.append(member(seat, x, end * (depth / 2 + reach + rng.uniform(0, 0.08)), yaw_rad=yaw))
        if along == 1 or rng.uniform() < 0.4:
            yaw = end * math.pi / 2 + rng.normal(0, 0.05)
            members.append(member(seat, end * (width / 2 + reach + rng.uniform(0, 0.06)), 0, yaw_rad=yaw))
    return together(members)


def rug(
    rng: np.random.Generator, style: Style, width_m: float, depth_m: float, *, y_m: float = 0.0
) -> Member:
    mat = box((width_m, depth_m, 0.009), bevel_m=0.004).with_uv_offset(*rng.uniform(0, 1, 2))
    return member(piece(BACKGROUND, [(mat, style.rug)]), 0, y_m, blocks=False)
