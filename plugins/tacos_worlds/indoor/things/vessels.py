"""Bottles, bowls of fruit, vases of flowers, kettles."""

from __future__ import annotations

import math

import numpy as np

from tacos_worlds.indoor.things.tableware import glaze
from tacos_worlds.kit.colours import Colour, linear, muted
from tacos_worlds.kit.finishes import BLACK_PLASTIC, STEEL, Finish, Style
from tacos_worlds.kit.mesh import Floats, Mesh, merged
from tacos_worlds.kit.piece import Piece, piece
from tacos_worlds.kit.shapes import disc_stack, sheet, tube

_BOTTLES: tuple[Colour, ...] = (
    (0.015, 0.05, 0.02), (0.05, 0.018, 0.008), (0.30, 0.36, 0.38), (0.02, 0.07, 0.03),
)  # fmt: skip
_FRUITS: tuple[Colour, ...] = ((0.50, 0.03, 0.02), (0.70, 0.25, 0.02), (0.30, 0.45, 0.04), (0.70, 0.50, 0.05))
_PETALS: tuple[Colour, ...] = ((0.65, 0.04, 0.06), (0.75, 0.55, 0.05), (0.70, 0.30, 0.45), (0.78, 0.76, 0.72))
_STALK = Finish("", (0.06, 0.16, 0.04), roughness=0.8)


def bottle(rng: np.random.Generator, style: Style) -> Piece:
    high, radius = rng.uniform(0.24, 0.33), rng.uniform(0.032, 0.042)
    shape = [
        (0.9 * radius, 0), (radius, 0.008), (radius, 0.58 * high), (0.4 * radius, 0.75 * high),
        (0.36 * radius, high), (0.1 * radius, high + 0.004),
    ]  # fmt: skip
    label = disc_stack([(radius + 0.0012, 0.18 * high), (radius + 0.0012, 0.46 * high)], sides=12)
    glass = Finish("", _BOTTLES[int(rng.integers(len(_BOTTLES)))], roughness=0.12)
    paper = Finish("", linear(muted(rng, saturation=(0.05, 0.4), value=(0.6, 0.95))), roughness=0.8)
    return piece("bottle", [(disc_stack(shape, sides=12), glass), (label, paper)])


def fruit_bowl(rng: np.random.Generator, style: Style) -> Piece:
    radius = rng.uniform(0.11, 0.15)
    bowl = [
        (0.5 * radius, 0),
        (0.85 * radius, 0.03),
        (radius, 0.075),
        (0.96 * radius, 0.075),
        (0.7 * radius, 0.035),
        (0.05, 0.03),
    ]
    parts = [(disc_stack(bowl, sides=16), glaze(rng) if rng.uniform() < 0.6 else style.wood)]
    kinds = rng.choice(len(_FRUITS), 2, replace=False)
    for kind in kinds.tolist():
        fruits: list[Mesh] = []
        for _ in range(int(rng.integers(2, 4))):
            at, size = rng.uniform(0, 2 * math.pi), rng.uniform(0.032, 0.04)
            out = rng.uniform(0.25, 0.5) * radius
            fruits.append(
                _ball(size, (out * math.cos(at), out * math.sin(at), 0.04 + size + rng.uniform(0, 0.02)))
            )
        parts.append((merged(fruits), Finish("", _FRUITS[kind], roughness=0.45)))
    return piece("bowl", parts)


def vase(rng: np.random.Generator, style: Style) -> Piece:
    high, radius = rng.uniform(0.16, 0.26), rng.uniform(0.045, 0.065)
    body = [(0.7 * radius, 0), (radius, 0.4 * high), (0.5 * radius, 0.85 * high), (0.62 * radius, high)]
    stalks, heads = [], []
    for k in range(int(rng.integers(4, 7))):
        turn, out = 2.4 * k + rng.uniform(0, 0.5), rng.uniform(0.02, 0.10)
        tip = np.array([out * math.cos(turn), out * math.sin(turn), high + rng.uniform(0.10, 0.2)])
        stalks.append(
            tube([(0, 0, 0.7 * high), tuple(0.5 * tip + [0, 0, 0.5 * high]), tuple(tip)], 0.0025, sides=3)
        )
        stalks.append(_leaf(np.array([0, 0, 0.95 * high]), 0.8 * tip + [0.0, 0.0, 0.1 * high]))
        heads.append(_ball(rng.uniform(0.018, 0.028), (float(tip[0]), float(tip[1]), float(tip[2]))))
    petals = Finish("", _PETALS[int(rng.integers(len(_PETALS)))], roughness=0.9)
    return piece(
        "vase", [(disc_stack(body, sides=12), glaze(rng)), (merged(stalks), _STALK), (merged(heads), petals)]
    )


def kettle(rng: np.random.Generator, style: Style) -> Piece:
    body = [(0.075, 0.02), (0.08, 0.04), (0.06, 0.2), (0.05, 0.215), (0.012, 0.222), (0.012, 0.24)]
    handle = tube([(0.06, 0, 0.19), (0.115, 0, 0.185), (0.12, 0, 0.07), (0.075, 0, 0.05)], 0.009, sides=6)
    spout = tube([(-0.05, 0, 0.15), (-0.088, 0, 0.2)], [0.02, 0.011], sides=6)
    skin = STEEL if rng.uniform() < 0.6 else Finish("moulded", (0.8, 0.79, 0.76), roughness=0.35)
    base = disc_stack([(0.085, 0), (0.085, 0.02)], sides=14)
    return piece(
        "kettle",
        [(merged([disc_stack(body, sides=14), spout]), skin), (merged([handle, base]), BLACK_PLASTIC)],
    )


def _ball(radius: float, at: tuple[float, float, float]) -> Mesh:
    return disc_stack(
        [(radius * c, radius * s) for c, s in ((0.35, -0.94), (0.92, -0.38), (0.92, 0.38), (0.35, 0.94))],
        at,
        sides=8,
    )


def _leaf(root: Floats, tip: Floats) -> Mesh:
    across = np.cross(tip - root, [0, 0, 1.0])
    across *= 0.016 / max(float(np.linalg.norm(across)), 1e-9)
    middle = (root + tip) / 2 + np.array([0, 0, 0.01])
    widths = ((root, 0.2), (middle, 1.0), (tip, 0.1))
    return sheet(np.array([[at - share * across, at + share * across] for at, share in widths]))
