"""Cups, glasses and plates with what one eats with."""

from __future__ import annotations

import numpy as np

from tacos_worlds.kit.colours import linear, muted
from tacos_worlds.kit.finishes import CERAMIC, STEEL, Finish, Style
from tacos_worlds.kit.mesh import Mesh, merged
from tacos_worlds.kit.piece import Piece, piece
from tacos_worlds.kit.shapes import disc_stack, slab, tube

_TEA = Finish("", (0.10, 0.035, 0.012), roughness=0.3)
_GLASS = Finish("", (0.34, 0.40, 0.42), roughness=0.15)


def glaze(rng: np.random.Generator) -> Finish:
    if rng.uniform() < 0.45:
        return CERAMIC
    return Finish("glaze", linear(muted(rng, saturation=(0.2, 0.6), value=(0.4, 0.9))), roughness=0.2)


def mug(rng: np.random.Generator, style: Style) -> Piece:
    high, radius = rng.uniform(0.085, 0.105), rng.uniform(0.037, 0.044)
    wall = [
        (radius * 0.9, 0), (radius, 0.01), (radius, high), (radius - 0.004, high),
        (radius - 0.005, 0.75 * high),
    ]  # fmt: skip
    reach, low, top = radius + 0.026, 0.28 * high, 0.78 * high
    handle = tube(
        [(radius - 0.004, 0, low), (reach, 0, low), (reach, 0, top), (radius - 0.004, 0, top)], 0.005, sides=5
    )
    tea = disc_stack([(radius - 0.004, 0.7 * high), (radius - 0.004, 0.76 * high)], sides=10)
    return piece("cup", [(merged([disc_stack(wall, sides=12), handle]), glaze(rng)), (tea, _TEA)])


def drinking_glass(rng: np.random.Generator, style: Style) -> Piece:
    high, radius = rng.uniform(0.10, 0.14), rng.uniform(0.03, 0.038)
    wall = [(0.8 * radius, 0), (radius, high), (radius - 0.003, high), (0.75 * radius, 0.02)]
    return piece("cup", [(disc_stack(wall, sides=10), _GLASS)])


def plate(rng: np.random.Generator, style: Style) -> Piece:
    radius = rng.uniform(0.11, 0.135)
    dish = [(0.55 * radius, 0), (radius, 0.016), (radius, 0.019), (0.62 * radius, 0.007), (0.05, 0.006)]
    cutlery: list[Mesh] = []
    for side, wide in ((-1, 0.022), (1, 0.016)):
        x = side * (radius + 0.03)
        cutlery.append(slab((0.009, 0.12, 0.003), (x, -0.03, 0)))
        cutlery.append(slab((wide, 0.07, 0.003), (x, 0.065, 0)))
    return piece("plate", [(disc_stack(dish, sides=18), glaze(rng)), (merged(cutlery), STEEL)])
