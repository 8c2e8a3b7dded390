"""Dining tables, desks, coffee tables, side tables."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from tacos_worlds.kit.finishes import Finish, Style
from tacos_worlds.kit.mesh import Mesh
from tacos_worlds.kit.piece import Piece, Top, piece
from tacos_worlds.kit.rectangle import Rect
from tacos_worlds.kit.shapes import box, disc_stack, loft, superellipse, tube


def dining_table(rng: np.random.Generator, style: Style) -> Piece:
    """A table for four to six, with legs at the corners or a central column."""
    size = (rng.uniform(1.4, 1.9), rng.uniform(0.8, 0.95), rng.uniform(0.73, 0.77))
    if rng.uniform() < 0.25:
        diameter = rng.uniform(1.1, 1.3)
        return _round_table(rng, style, diameter, size[2], use="meal")
    return _four_legs(rng, style, size, top=rng.uniform(0.025, 0.045), use="meal")


def desk(rng: np.random.Generator, style: Style) -> Piece:
    """A desk with a drawer box or plain legs."""
    width, depth, height = rng.uniform(1.2, 1.6), rng.uniform(0.65, 0.75), rng.uniform(0.72, 0.75)
    plain = _four_legs(rng, style, (width, depth, height), top=0.028, use="desk")
    if rng.uniform() < 0.6:
        drawers = _drawers(style, (0.4, depth - 0.1, height - 0.03), int(rng.choice([2, 3])))
        at = width / 2 - 0.27
        return replace(plain, parts=plain.parts + tuple((mesh.moved(at, 0, 0), f) for mesh, f in drawers))
    return plain


def coffee_table(rng: np.random.Generator, style: Style) -> Piece:
    """A low table, rectangular or round, sometimes with a shelf below."""
    height = rng.uniform(0.36, 0.46)
    if rng.uniform() < 0.4:
        return _round_table(rng, style, rng.uniform(0.7, 0.95), height, use="low")
    width, depth = rng.uniform(0.9, 1.2), rng.uniform(0.5, 0.65)
    made = _four_legs(rng, style, (width, depth, height), top=0.03, use="low")
    shelf = box((width - 0.12, depth - 0.12, 0.018), (0, 0, height * 0.35))
    return replace(made, parts=(*made.parts, (shelf, style.wood)))


def side_table(rng: np.random.Generator, style: Style) -> Piece:
    """A small table beside a bed or sofa: a drawer box on legs, or a round top on a column."""
    height = rng.uniform(0.45, 0.58)
    if rng.uniform() < 0.4:
        return _round_table(rng, style, rng.uniform(0.4, 0.5), height, use="bedside")
    width, depth, leg = rng.uniform(0.4, 0.5), rng.uniform(0.36, 0.42), rng.uniform(0.08, 0.2)
    parts = [
        (mesh.moved(0, 0, leg), finish) for mesh, finish in _drawers(style, (width, depth, height - leg), 2)
    ]
    parts += _legs(rng, style, width - 0.04, depth - 0.04, leg + 0.005, 0.035)
    return piece("table", parts, tops=[_top(width, depth, height, "bedside")])


def _four_legs(
    rng: np.random.Generator, style: Style, size: tuple[float, float, float], *, top: float, use: str
) -> Piece:
    width, depth, height = size
    tops = [_top(width, depth, height, use)]
    metal_legs = rng.uniform() < 0.35
    thick = rng.uniform(0.045, 0.075)
    parts: list[tuple[Mesh, Finish]] = [
        (
            box((width, depth, top), (0, 0, height - top), bevel_m=min(0.008, top / 3)).with_uv_offset(
                *rng.uniform(0, 1, 2)
            ),
            style.wood,
        )
    ]
    if metal_legs:
        for x in (-1, 1):
            foot, head = x * (width / 2 - 0.08), x * (width / 2 - 0.16)
            y = depth / 2 - 0.07
            path = [[foot, -y, 0.0], [head, -y, height - top], [head, y, height - top], [foot, y, 0.0]]
            for start, end in pairwise(path):
                parts.append((tube([start, end], 0.016), style.metal))
        return piece("table", parts, tops=tops)
    parts += _legs(rng, style, width, depth, height - top, thick)
    apron = 0.075
    for y in (-1, 1):
        parts.append(
            (box((width - 0.16, 0.02, apron), (0, y * (depth / 2 - 0.06), height - top - apron)), style.wood)
        )
    for x in (-1, 1):
        parts.append(
            (box((0.02, depth - 0.16, apron), (x * (width / 2 - 0.06), 0, height - top - apron)), style.wood)
        )
    return piece("table", parts, tops=tops)


def _top(width: float, depth: float, height: float, use: str) -> Top:
    """The top of a table but for its rim."""
    x, y = width / 2 - 0.03, depth / 2 - 0.03
    return Top(Rect(-x, -y, x, y), height, use)


def _legs(
    rng: np.random.Generator, style: Style, width: float, depth: float, height: float, thick: float
) -> list[tuple[Mesh, Finish]]:
    turned = rng.uniform() < 0.4
    found: list[tuple[Mesh, Finish]] = []
    for x in (-1, 1):
        for y in (-1, 1):
            at = (x * (width / 2 - thick * 0.7), y * (depth / 2 - thick * 0.7), 0.0)
            if turned:
                profile = [(thick * 0.3, 0), (thick * 0.42, height * 0.6), (thick * 0.5, height)]
                found.append((disc_stack(profile, at, sides=10), style.wood))
            else:
                found.append((box((thick, thick, height), at, bevel_m=0.005), style.wood))
    return found


def _round_table(
    rng: np.random.Generator, style: Style, diameter: float, height: float, *, use: str
) -> Piece:
    top = rng.uniform(0.022, 0.035)
    radius = diameter / 2
    rim = [
        superellipse(radius - inset, radius - inset, height - top + z, power=2.0, sides=24)
        for inset, z in ((0.006, 0.0), (0.0, 0.006), (0.0, top - 0.006), (0.006, top))
    ]
    surface = style.wood if rng.uniform() < 0.7 else Finish("marble", (0.85, 0.84, 0.82), roughness=0.25)
    foot = max(0.14, 0.55 * radius)
    column = [
        (foot, 0),
        (foot, 0.018),
        (0.06, 0.045),
        (0.035, 0.12),
        (0.035, height - top - 0.05),
        (0.09, height - top),
    ]
    return piece(
        "table",
        [
            (loft(rim), surface),
            (disc_stack(column, sides=16), style.metal if surface is not style.wood else style.wood),
        ],
        tops=[_top(1.41 * radius, 1.41 * radius, height, use)],  # the square within
    )


def _drawers(style: Style, size: tuple[float, float, float], count: int) -> list[tuple[Mesh, Finish]]:
    width, depth, height = size
    found: list[tuple[Mesh, Finish]] = [(box((width, depth, height), bevel_m=0.004), style.wood)]
    face = height / count
    for row in range(count):
        low = row * face
        found.append(
            (
                box((width - 0.02, 0.018, face - 0.012), (0, depth / 2 + 0.004, low + 0.006), bevel_m=0.003),
                style.second_wood,
            )
        )
        found.append(
            (box((0.12, 0.02, 0.012), (0, depth / 2 + 0.02, low + face * 0.6), bevel_m=0.004), style.metal)
        )
    return found
