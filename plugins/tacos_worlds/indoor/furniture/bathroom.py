"""Bathtubs, washbasins, and the toilet that belongs beside them."""

from __future__ import annotations

import numpy as np

from tacos_worlds.kit.finishes import CERAMIC, CHROME, Finish, Style
from tacos_worlds.kit.mesh import Floats, Mesh
from tacos_worlds.kit.piece import BACKGROUND, Piece, piece
from tacos_worlds.kit.shapes import box, cushion, disc_stack, loft, superellipse, tube


def bathtub(rng: np.random.Generator, style: Style) -> Piece:
    """A tub with a hollow inside: free-standing and oval, or built into a panelled box."""
    length, width, height = rng.uniform(1.6, 1.8), rng.uniform(0.72, 0.82), rng.uniform(0.54, 0.62)
    oval = rng.uniform() < 0.5
    power = 2.6 if oval else 7.0
    x, y = length / 2, width / 2
    outside = (
        [(0.80, 0.0), (0.84, 0.03), (0.95, height * 0.6), (1.0, height - 0.02)]
        if oval
        else [(1.0, 0.0), (1.0, height - 0.02)]
    )
    rim = [(1.0, height), (0.98, height + 0.008)]
    inside = [(0.90, height), (0.87, height - 0.03), (0.80, 0.22), (0.70, 0.14), (0.3, 0.12)]
    rings: list[Floats] = []
    for scale, z in outside + rim:
        rings.append(superellipse(x * scale, y * scale, z, power=power, sides=28))
    for scale, z in inside:
        shrink = x * (1 - scale)  # the wall is as thick along the sides as at the ends
        rings.append(superellipse(x - shrink, max(y - shrink, 0.08), z, power=2.8, sides=28))
    parts: list[tuple[Mesh, Finish]] = [(loft(rings), CERAMIC)]
    spout = [
        [-x * 0.96, 0, height],
        [-x * 0.96, 0, height + 0.18],
        [-x * 0.88, 0, height + 0.22],
        [-x * 0.78, 0, height + 0.17],
    ]
    parts.append((tube(spout, 0.014), CHROME))
    for side in (-1, 1):
        parts.append(
            (
                disc_stack(
                    [(0.02, 0), (0.02, 0.05), (0.012, 0.06)], (-x * 0.95, side * 0.09, height), sides=10
                ),
                CHROME,
            )
        )
    parts.append((disc_stack([(0.03, 0.121), (0.028, 0.128)], (-x * 0.4, 0, 0), sides=12), CHROME))
    return piece("bathtub", parts)


def basin(rng: np.random.Generator, style: Style) -> Piece:
    """A washbasin: on a vanity unit, or on a pedestal."""
    width, depth, height = rng.uniform(0.55, 0.75), rng.uniform(0.44, 0.5), rng.uniform(0.82, 0.88)
    power = float(rng.choice([2.4, 4.0, 6.0]))
    bowl = 0.16
    rings = [
        superellipse(width / 2 * s, depth / 2 * s, height - bowl + z, power=power, sides=20)
        for s, z in ((0.55, 0.0), (0.8, 0.03), (0.98, bowl * 0.6), (1.0, bowl - 0.01), (0.985, bowl))
    ]
    rings += [
        superellipse(width / 2 * s, depth / 2 * s - 0.02, height - bowl + z, power=2.6, sides=20)
        + np.array([0, 0.025, 0])
        for s, z in ((0.86, bowl), (0.82, bowl - 0.015), (0.62, 0.05), (0.12, 0.035))
    ]
    parts: list[tuple[Mesh, Finish]] = [(loft(rings), CERAMIC)]
    rear = -depth / 2
    if rng.uniform() < 0.6:
        unit = height - bowl + 0.005
        parts.append(
            (box((width - 0.04, depth - 0.04, unit - 0.14), (0, -0.01, 0.14), bevel_m=0.004), style.wood)
        )
        for x in (-1, 1):
            front = (x * (width - 0.04) / 4, depth / 2 - 0.025, 0.15)
            parts.append(
                (
                    box(((width - 0.05) / 2 - 0.004, 0.018, unit - 0.17), front, bevel_m=0.003),
                    style.second_wood,
                )
            )
            parts.append(
                (box((0.012, 0.02, 0.12), (x * 0.025, depth / 2 - 0.01, unit - 0.2), bevel_m=0.004), CHROME)
            )
            for y in (-1, 1):
                parts.append(
                    (
                        disc_stack(
                            [(0.012, 0), (0.018, 0.145)],
                            (x * (width / 2 - 0.07), y * (depth / 2 - 0.08), 0),
                            sides=8,
                        ),
                        CHROME,
                    )
                )
    else:
        column = [
            superellipse(a, b, z, power=3.0, sides=16) + np.array([0, -0.03, 0])
            for a, b, z in (
                (0.12, 0.11, 0),
                (0.11, 0.1, 0.05),
                (0.075, 0.07, 0.35),
                (0.1, 0.1, height - bowl + 0.02),
            )
        ]
        parts.append((loft(column), CERAMIC))
    tap_y = rear + 0.05
    tap = [
        [0, tap_y, height - 0.02],
        [0, tap_y, height + 0.13],
        [0, tap_y + 0.05, height + 0.17],
        [0, tap_y + 0.12, height + 0.14],
    ]
    parts.append((tube(tap, 0.013), CHROME))
    parts.append((box((0.02, 0.06, 0.012), (0, tap_y + 0.005, height + 0.165), bevel_m=0.004), CHROME))
    return piece("basin", parts)


def toilet(rng: np.random.Generator, style: Style) -> Piece:
    """A toilet with a cistern; it carries no label."""
    rings = [
        superellipse(a, b, z, power=2.4, sides=18) + np.array([0, shift, 0])
        for a, b, z, shift in (
            (0.12, 0.22, 0, 0),
            (0.11, 0.2, 0.08, 0),
            (0.13, 0.2, 0.22, 0.02),
            (0.185, 0.26, 0.38, 0.04),
            (0.185, 0.26, 0.40, 0.04),
        )
    ]
    lid = [superellipse(0.19, 0.24, z, power=2.3, sides=18) + np.array([0, 0.06, 0]) for z in (0.402, 0.43)]
    parts = [
        (loft(rings), CERAMIC),
        (loft(lid), Finish("moulded", (0.85, 0.85, 0.84), roughness=0.3)),
        (cushion((0.38, 0.17, 0.38), (0, -0.26, 0.4), round_m=0.03), CERAMIC),
        (disc_stack([(0.025, 0), (0.025, 0.01)], (0, -0.26, 0.78), sides=10), CHROME),
    ]
    return piece(BACKGROUND, parts)
