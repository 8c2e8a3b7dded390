"""Toys that lie on the floor."""

from __future__ import annotations

import math

import numpy as np

from tacos_worlds.kit.colours import linear, vivid
from tacos_worlds.kit.finishes import Finish, Style
from tacos_worlds.kit.mesh import Mesh, rotation_x, rotation_y
from tacos_worlds.kit.piece import Piece, piece
from tacos_worlds.kit.shapes import box, cushion, disc_stack


def toy(rng: np.random.Generator, style: Style) -> Piece:
    makers = (_ball, _blocks, _car, _tower, _bear)
    return piece("toy", makers[int(rng.integers(len(makers)))](rng))


def _plastic(rng: np.random.Generator) -> Finish:
    return Finish("moulded", linear(vivid(rng)), roughness=0.4)


def _sphere(radius: float, at: tuple[float, float, float], sides: int = 12) -> Mesh:
    angle = np.linspace(-0.5 * math.pi, 0.5 * math.pi, sides // 2 + 2)[1:-1]
    return disc_stack([(radius * math.cos(a), radius * math.sin(a)) for a in angle], at, sides=sides)


def _ball(rng: np.random.Generator) -> list[tuple[Mesh, Finish]]:
    radius = rng.uniform(0.08, 0.13)
    printed = Finish(
        str(rng.choice(["stripes", "blossoms", "plaid"])), variant=int(rng.integers(2)), roughness=0.5
    )
    return [(_sphere(radius, (0, 0, radius)), printed if rng.uniform() < 0.5 else _plastic(rng))]


def _blocks(rng: np.random.Generator) -> list[tuple[Mesh, Finish]]:
    edge = rng.uniform(0.07, 0.1)
    found = []
    for x, y, level in ((0, 0, 0), (1.25, 0.1, 0), (0.3, 1.2, 0), (0.6, 0.15, 1), (1.5, 1.1, 0)):
        cube = box((edge, edge, edge), bevel_m=0.006).turned(rng.uniform(-0.5, 0.5))
        found.append((cube.moved(x * edge, y * edge, level * edge), _plastic(rng)))
    return found


def _car(rng: np.random.Generator) -> list[tuple[Mesh, Finish]]:
    length = rng.uniform(0.2, 0.3)
    width, wheel = length * 0.5, length * 0.12
    paint = _plastic(rng)
    found = [
        (cushion((width, length, length * 0.22), (0, 0, wheel * 0.7), round_m=length * 0.06), paint),
        (
            cushion(
                (width * 0.8, length * 0.5, length * 0.2),
                (0, -length * 0.05, wheel * 0.7 + length * 0.2),
                round_m=length * 0.06,
            ),
            paint,
        ),
    ]
    rubber = Finish("moulded", (0.03, 0.03, 0.03), roughness=0.9)
    for x in (-1, 1):
        for y in (-0.3, 0.3):
            tyre = disc_stack(
                [(wheel * 0.8, -0.02), (wheel, -0.012), (wheel, 0.012), (wheel * 0.8, 0.02)], sides=12
            )
            found.append(
                (tyre.rotated(rotation_y(math.pi / 2)).moved(x * width / 2, y * length, wheel), rubber)
            )
    return found


def _tower(rng: np.random.Generator) -> list[tuple[Mesh, Finish]]:
    found, low = [], 0.0
    for level in range(5):
        radius, height = 0.09 - 0.013 * level, 0.038
        ring = [
            (radius * 0.8, low),
            (radius, low + height * 0.3),
            (radius, low + height * 0.7),
            (radius * 0.8, low + height),
        ]
        found.append((disc_stack(ring, sides=14), _plastic(rng)))
        low += height
    found.append((_sphere(0.03, (0, 0, low + 0.025), 10), _plastic(rng)))
    return found


def _bear(rng: np.random.Generator) -> list[tuple[Mesh, Finish]]:
    size = rng.uniform(0.9, 1.4)
    fur = Finish(
        "pile",
        [(0.45, 0.28, 0.15), (0.62, 0.48, 0.32), (0.30, 0.20, 0.14), (0.7, 0.66, 0.6)][int(rng.integers(4))],
        roughness=0.98,
    )
    found = [
        (_sphere(0.11 * size, (0, 0, 0.11 * size)), fur),
        (_sphere(0.08 * size, (0, 0.01, 0.26 * size)), fur),
    ]
    for x in (-1, 1):
        found.append((_sphere(0.03 * size, (x * 0.06 * size, 0, 0.33 * size), 8), fur))
        limb = cushion((0.07 * size, 0.16 * size, 0.07 * size), (0, 0, -0.035 * size), round_m=0.034 * size)
        found.append((limb.moved(x * 0.08 * size, 0.12 * size, 0.045 * size), fur))
        arm = limb.rotated(rotation_x(-0.9)).moved(x * 0.11 * size, 0.06 * size, 0.16 * size)
        found.append((arm, fur))
    found.append(
        (
            _sphere(0.03 * size, (0, 0.08 * size, 0.25 * size), 8),
            Finish("pile", (0.75, 0.65, 0.5), roughness=0.98),
        )
    )
    return found
