"""Kitchen units: a worktop with cupboards below, a hob and a sink, and cupboards on the wall above."""

from __future__ import annotations

import numpy as np

from tacos_worlds.indoor.furniture.storage import cupboard
from tacos_worlds.kit.finishes import CHROME, STEEL, Finish, Style
from tacos_worlds.kit.mesh import Mesh
from tacos_worlds.kit.piece import BACKGROUND, Piece, Top, piece
from tacos_worlds.kit.rectangle import Rect
from tacos_worlds.kit.shapes import box, disc_stack, panel, slab, tube

_COLUMN_M = 0.6
_WORKTOP_M = 0.895
_ABOVE_M, _ABOVE_HIGH_M, _ABOVE_DEEP_M = 1.42, 0.7, 0.34
"""Lower edge, height and depth of the cupboards on the wall [m]."""

Parts = list[tuple[Mesh, Finish]]


def kitchen_unit(rng: np.random.Generator, style: Style) -> Piece:
    """A row of cupboards with a worktop; most have tiles and cupboards above."""
    columns = int(rng.integers(3, 5))
    width, depth = columns * _COLUMN_M, 0.6
    base = cupboard(style, width, depth - 0.02, 0.86, columns=columns, rows=1, plinth=0.1)
    dark = rng.uniform() < 0.5
    stone = Finish("marble", (0.35, 0.34, 0.33) if dark else (0.8, 0.79, 0.76), roughness=0.3)
    worktop = box((width + 0.02, depth + 0.02, 0.035), (0, 0.01, 0.86), bevel_m=0.005)
    middle = [(k - (columns - 1) / 2) * _COLUMN_M for k in range(columns)]
    hob = columns // 2
    parts: Parts = [*base.parts, (worktop, stone), *_hob(middle[hob]), *_sink(middle[0])]
    if rng.uniform() < 0.75:
        parts += _above(style, middle, depth, hob)
    free = [
        Top(Rect(x - 0.27, -0.24, x + 0.27, 0.25), _WORKTOP_M, "counter")
        for number, x in enumerate(middle)
        if number not in (0, hob)
    ]
    return piece(BACKGROUND, parts, tops=free)


def _hob(x: float) -> Parts:
    glass = Finish("", (0.015, 0.015, 0.017), roughness=0.1)
    pot = [(0.09, 0), (0.11, 0.01), (0.11, 0.13), (0.1, 0.13), (0.1, 0.03)]
    return [
        (box((0.56, 0.5, 0.008), (x, 0, _WORKTOP_M), bevel_m=0.003), glass),
        (disc_stack(pot, (x + 0.13, 0.1, 0.903), sides=14), STEEL),
    ]


def _sink(x: float) -> Parts:
    tap = [[x, -0.2, 0.89], [x, -0.2, 1.15], [x, -0.1, 1.2], [x, -0.03, 1.13]]
    return [
        (box((0.44, 0.38, 0.006), (x, 0.02, _WORKTOP_M), bevel_m=0.002), STEEL),
        (tube(tap, 0.012), CHROME),
    ]


def _above(style: Style, middle: list[float], depth: float, hob: int) -> Parts:
    """Tiles behind the worktop, cupboards above it, and a hood over the hob."""
    wall = -depth / 2
    width = len(middle) * _COLUMN_M
    tiles = panel([width / 2, wall + 0.004, _WORKTOP_M], [-width, 0, 0], [0, 0, 0.52], step_m=1.0)
    parts: Parts = [(tiles, Finish("wall_tiles", (0.86, 0.85, 0.82), roughness=0.25))]
    at = wall + _ABOVE_DEEP_M / 2
    for number, x in enumerate(middle):
        if number == hob:
            parts.append((box((0.58, 0.42, 0.06), (x, wall + 0.21, 1.55), bevel_m=0.01), STEEL))
            parts.append((slab((0.24, 0.24, 0.52), (x, wall + 0.12, 1.6)), STEEL))
            continue
        front = at + _ABOVE_DEEP_M / 2
        body = slab((_COLUMN_M, _ABOVE_DEEP_M, _ABOVE_HIGH_M), (x, at, _ABOVE_M))
        door = box(
            (_COLUMN_M - 0.008, 0.018, _ABOVE_HIGH_M - 0.008),
            (x, front + 0.006, _ABOVE_M + 0.004),
            bevel_m=0.004,
        )
        parts += [(body, style.wood), (door, style.wood)]
        parts.append((slab((0.012, 0.024, 0.14), (x - 0.22, front + 0.022, _ABOVE_M + 0.05)), style.metal))
    return parts
