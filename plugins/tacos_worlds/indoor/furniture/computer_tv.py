"""Television sets and computers."""

from __future__ import annotations

import math

import numpy as np

from tacos_worlds.kit.finishes import BLACK_PLASTIC, DARK_GLASS, GREY_PLASTIC, STEEL, Finish, Style
from tacos_worlds.kit.mesh import Mesh, rotation_x
from tacos_worlds.kit.piece import Piece, piece
from tacos_worlds.kit.shapes import box, panel, slab


def television(rng: np.random.Generator, style: Style) -> Piece:
    width = rng.uniform(0.95, 1.35)
    height = width * 9 / 16 + 0.03
    foot = 0.07
    parts: list[tuple[Mesh, Finish]] = [
        (box((width, 0.035, height), (0, 0, foot), bevel_m=0.006), BLACK_PLASTIC),
        (
            box((width * 0.6, 0.04, height * 0.5), (0, -0.03, foot + height * 0.15), bevel_m=0.012),
            BLACK_PLASTIC,
        ),
        (_screen(width - 0.024, height - 0.034, y=0.0185, z=foot + 0.022), DARK_GLASS),
    ]
    for x in (-1, 1):
        parts.append((box((0.03, 0.22, 0.012), (x * width * 0.35, 0, 0), bevel_m=0.004), BLACK_PLASTIC))
        parts.append((slab((0.025, 0.025, foot), (x * width * 0.35, 0, 0.01)), BLACK_PLASTIC))
    return piece("computer_tv", parts)


def computer(rng: np.random.Generator, style: Style) -> Piece:
    """A monitor with keyboard and mouse, or a laptop; its picture is that of a page, not a light."""
    picture = Finish("desktop", variant=int(rng.integers(2)), roughness=0.25)
    if rng.uniform() < 0.3:
        return _laptop(picture, width=rng.uniform(0.31, 0.38))
    width = rng.uniform(0.54, 0.66)
    height = width * 0.58
    low = rng.uniform(0.1, 0.14)
    rear = -0.18
    parts: list[tuple[Mesh, Finish]] = [
        (box((width, 0.04, height), (0, rear, low), bevel_m=0.008), BLACK_PLASTIC),
        (_screen(width - 0.02, height - 0.03, y=rear + 0.021, z=low + 0.02), picture.scaled_to(width)),
        (box((0.05, 0.03, low + 0.12), (0, rear - 0.03, 0.0)), GREY_PLASTIC),
        (box((0.24, 0.18, 0.014), (0, rear, 0), bevel_m=0.004), GREY_PLASTIC),
        (box((0.42, 0.13, 0.018), (0, 0.09, 0), bevel_m=0.005), GREY_PLASTIC),
        (box((0.06, 0.1, 0.03), (0.3, 0.09, 0), bevel_m=0.012), BLACK_PLASTIC),
    ]
    for row in range(4):
        parts.append((slab((0.40, 0.022, 0.006), (0, 0.045 + 0.029 * row, 0.018)), BLACK_PLASTIC))
    return piece("computer_tv", parts)


def _laptop(picture: Finish, *, width: float) -> Piece:
    depth = 0.7 * width
    lid = box((width, 0.01, depth), (0, 0, 0), bevel_m=0.003)
    screen = _screen(width - 0.02, depth - 0.02, y=0.0055, z=0.01)
    tilt = rotation_x(math.radians(16))
    parts: list[tuple[Mesh, Finish]] = [
        (box((width, depth, 0.016), bevel_m=0.004), STEEL),
        (slab((width - 0.05, depth * 0.45, 0.002), (0, -0.03, 0.0155)), BLACK_PLASTIC),
        (lid.rotated(tilt).moved(0, -depth / 2, 0.014), STEEL),
        (screen.rotated(tilt).moved(0, -depth / 2, 0.014), picture.scaled_to(width)),
    ]
    return piece("computer_tv", parts)


def _screen(width: float, height: float, *, y: float, z: float) -> Mesh:
    return panel([width / 2, y, z], [-width, 0, 0], [0, 0, height], step_m=1.0)
