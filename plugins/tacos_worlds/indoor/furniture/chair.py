"""Chairs: wooden dining chairs and office chairs on castors."""

from __future__ import annotations

import math

import numpy as np

from tacos_worlds.kit.finishes import BLACK_PLASTIC, Finish, Style
from tacos_worlds.kit.mesh import Mesh, rotation_x
from tacos_worlds.kit.piece import Piece, Seat, piece
from tacos_worlds.kit.shapes import box, cushion, disc_stack, tube


def dining_chair(rng: np.random.Generator, style: Style) -> Piece:
    """A four-legged chair; slats or a board as its back, a wooden or padded seat."""
    width, depth = rng.uniform(0.42, 0.46), rng.uniform(0.42, 0.47)
    seat, back = rng.uniform(0.43, 0.46), rng.uniform(0.82, 0.98)
    leg = rng.uniform(0.032, 0.042)
    lean = 0.07
    rear = -depth / 2 + leg / 2
    parts: list[tuple[Mesh, Finish]] = []
    for x in (-1, 1):
        side = x * (width / 2 - leg / 2)
        parts.append(
            (box((leg, leg, seat - 0.02), (side, depth / 2 - leg / 2, 0), bevel_m=0.005), style.wood)
        )
        post = tube([[side, rear, 0], [side, rear, seat], [side, rear - lean, back]], leg * 0.5, sides=6)
        parts.append((post, style.wood))
    if rng.uniform() < 0.5:
        parts.append((box((width, depth, 0.028), (0, 0, seat - 0.028), bevel_m=0.01), style.wood))
    else:
        parts.append(
            (cushion((width, depth, 0.06), (0, 0, seat - 0.04), round_m=0.025, puff_m=0.01), style.accent)
        )
    slope = math.atan2(lean, back - seat)

    def on_back(mesh: Mesh, height: float) -> Mesh:
        return mesh.rotated(rotation_x(slope)).moved(0, rear - lean * (height - seat) / (back - seat), height)

    if rng.uniform() < 0.5:
        for step in range(int(rng.integers(2, 4))):
            height = back - 0.10 - 0.13 * step
            parts.append((on_back(box((width - leg, 0.018, 0.07), (0, 0, -0.035)), height), style.wood))
    else:
        parts.append((on_back(box((width - leg, 0.02, 0.08), (0, 0, -0.04)), back - 0.05), style.wood))
        for k in range(4):
            at = (k - 1.5) * (width - 0.1) / 4
            bar = box((0.025, 0.014, back - seat - 0.08), (at, 0, -(back - seat - 0.08) / 2), bevel_m=0.003)
            parts.append((on_back(bar, (back + seat) / 2 - 0.03), style.wood))
    parts.append((box((0.02, depth - leg, 0.03), (width / 2 - leg / 2, 0, seat * 0.45)), style.wood))
    parts.append((box((0.02, depth - leg, 0.03), (-width / 2 + leg / 2, 0, seat * 0.45)), style.wood))
    return piece("chair", parts, seats=[Seat(0.0, -0.03, seat + 0.01, back_deg=5.0)])


def office_chair(rng: np.random.Generator, style: Style) -> Piece:
    seat = rng.uniform(0.44, 0.5)
    width = rng.uniform(0.46, 0.52)
    cloth = Finish("weave", (0.06, 0.06, 0.065), roughness=0.95) if rng.uniform() < 0.6 else style.accent
    parts: list[tuple[Mesh, Finish]] = [
        (disc_stack([(0.03, 0.1), (0.03, 0.24), (0.02, 0.24), (0.02, seat - 0.05)], sides=10), style.metal),
        (cushion((width, 0.48, 0.09), (0, 0.03, seat - 0.05), round_m=0.04, puff_m=0.012), cloth),
    ]
    for arm in range(5):
        turn = arm * 2 * math.pi / 5 + 0.3
        end = np.array([math.cos(turn), math.sin(turn)]) * 0.29
        parts.append((tube([[0, 0, 0.13], [*end, 0.085]], [0.026, 0.016], sides=6), BLACK_PLASTIC))
        wheel = disc_stack(
            [(0.006, 0), (0.03, 0.018), (0.03, 0.045), (0.006, 0.06)], (end[0], end[1], 0.0), sides=8
        )
        parts.append((wheel, BLACK_PLASTIC))
    height = rng.uniform(0.48, 0.6)
    back = cushion((width - 0.04, height, 0.07), (0, 0, -0.035), round_m=0.03, puff_m=0.015)
    back = back.rotated(rotation_x(math.radians(98))).moved(0, -0.23, seat + 0.12 + height / 2)
    parts.append((back, cloth))
    parts.append((box((0.06, 0.02, 0.3), (0, -0.26, seat - 0.03)), BLACK_PLASTIC))
    if rng.uniform() < 0.6:
        for x in (-1, 1):
            side = x * (width / 2 + 0.02)
            parts.append((box((0.05, 0.24, 0.03), (side, 0.02, seat + 0.2), bevel_m=0.01), BLACK_PLASTIC))
            parts.append((box((0.03, 0.04, 0.24), (side, 0.0, seat - 0.03)), BLACK_PLASTIC))
    return piece("chair", parts, seats=[Seat(0.0, 0.0, seat + 0.04, back_deg=7.0)])
