"""Sofas and armchairs."""

from __future__ import annotations

import math

import numpy as np

from tacos_worlds.kit.finishes import Finish, Style
from tacos_worlds.kit.mesh import Mesh, rotation_x
from tacos_worlds.kit.piece import Piece, Seat, piece
from tacos_worlds.kit.shapes import box, cushion, disc_stack


def sofa(rng: np.random.Generator, style: Style) -> Piece:
    return _seat_row(rng, style, seats=int(rng.choice([2, 3, 3])))


def armchair(rng: np.random.Generator, style: Style) -> Piece:
    return _seat_row(rng, style, seats=1)


def _seat_row(rng: np.random.Generator, style: Style, *, seats: int) -> Piece:
    seat_width = rng.uniform(0.62, 0.74) if seats > 1 else rng.uniform(0.58, 0.68)
    depth = rng.uniform(0.84, 0.96)
    seat_height = rng.uniform(0.40, 0.46)
    back_height = rng.uniform(0.74, 0.90)
    arm_width = rng.uniform(0.12, 0.22)
    arm_height = rng.uniform(0.56, 0.66)
    leg = rng.uniform(0.05, 0.14)
    back_depth = 0.2
    cloth = style.upholstery
    inner = seats * seat_width
    width = inner + 2 * arm_width
    parts: list[tuple[Mesh, Finish]] = [
        (cushion((width - 0.02, depth - 0.02, seat_height - 0.16 - leg), (0, 0, leg), round_m=0.03), cloth),
        (
            cushion(
                (width, back_depth, back_height - leg), (0, -depth / 2 + back_depth / 2, leg), round_m=0.07
            ),
            cloth,
        ),
    ]
    for side in (-1, 1):
        at = (side * (width - arm_width) / 2, 0.02, leg)
        parts.append((cushion((arm_width, depth, arm_height - leg), at, round_m=0.05), cloth))
    gap = 0.008
    for seat in range(seats):
        x = (seat - (seats - 1) / 2) * seat_width
        seat_at = (x, back_depth / 2 + 0.02, seat_height - 0.17)
        size = (seat_width - gap, depth - back_depth - 0.03, 0.17)
        parts.append(
            (cushion(size, seat_at, round_m=0.05, puff_m=0.02).with_uv_offset(0.13 * seat, 0.07), cloth)
        )
        lean = cushion((seat_width - gap, 0.42, 0.16), (0, 0, -0.08), round_m=0.06, puff_m=0.03)
        lean = lean.rotated(rotation_x(math.radians(rng.uniform(74, 80))))
        lean = lean.moved(x, -depth / 2 + back_depth + 0.11, seat_height + 0.22)
        parts.append((lean.with_uv_offset(0.05, 0.11 * seat), cloth))
    pillows_m = []
    for _ in range(int(rng.integers(0, seats + 1))):
        x = rng.uniform(-0.42, 0.42) * inner
        pillows_m.append(x)
        pillow = cushion((0.42, 0.42, 0.14), (0, 0, -0.07), round_m=0.065, puff_m=0.02)
        pillow = pillow.rotated(rotation_x(math.radians(62))).turned(rng.uniform(-0.3, 0.3))
        parts.append((pillow.moved(x, -depth / 2 + back_depth + 0.27, seat_height + 0.22), style.accent))
    for x in (-1, 1):
        for y in (-1, 1):
            at = (x * (width / 2 - 0.08), y * (depth / 2 - 0.08), 0.0)
            if leg > 0.09:
                parts.append((disc_stack([(0.014, 0), (0.026, leg + 0.01)], at, sides=8), style.wood))
            else:
                parts.append((box((0.06, 0.06, leg + 0.01), at, bevel_m=0.004), style.wood))
    places = [(seat - (seats - 1) / 2) * seat_width for seat in range(seats)]
    free = [x for x in places if all(abs(x - pillow) > 0.45 for pillow in pillows_m)]
    hips = -depth / 2 + back_depth + 0.34
    return piece("sofa", parts, seats=[Seat(x, hips, seat_height, back_deg=14.0) for x in free])
