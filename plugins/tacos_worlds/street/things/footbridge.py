"""A footbridge over a street, with stairs on both pavements."""

from __future__ import annotations

import numpy as np

from tacos_worlds.kit.mesh import Mesh, merged
from tacos_worlds.kit.piece import Piece
from tacos_worlds.kit.shapes.boxes import slab
from tacos_worlds.kit.shapes.lofts import tube
from tacos_worlds.street.city import CARRIAGEWAY_M, KERB_M
from tacos_worlds.street.finishes import GREEN_METAL, STONE

CLEARANCE_M = 5.0
"""Height of its underside above the road [m]."""
WIDTH_M = 2.4
STAIRS_M = 8.0
"""Length of the stairs along the pavement [m]."""
_OVER_M = 2.6
_RAIL_M = 1.1
_STEPS = 16


def footbridge() -> Piece:
    """A footbridge in the frame of the right-hand kerb (x along it, y over the road), its middle at x = 0."""
    span = CARRIAGEWAY_M + 2 * _OVER_M
    middle = CARRIAGEWAY_M / 2
    top = CLEARANCE_M + 0.35
    concrete: list[Mesh] = [
        slab((WIDTH_M, span, 0.35), (0, middle, CLEARANCE_M)),
        slab((0.5, span, 0.5), (0, middle, CLEARANCE_M - 0.4)),
    ]
    metal: list[Mesh] = []
    for x in (-WIDTH_M / 2, WIDTH_M / 2):
        metal += _railing(np.array([x, middle - span / 2, top]), np.array([x, middle + span / 2, top]))
    for y in (-1.9, CARRIAGEWAY_M + 1.9):
        concrete += _stairs(y, top)
        concrete.append(slab((0.6, 0.9, CLEARANCE_M - KERB_M), (-0.6, y, KERB_M)))
        for side in (-0.7, 0.7):
            high = np.array([WIDTH_M / 2, y + side, top])
            low = np.array([WIDTH_M / 2 + STAIRS_M, y + side, KERB_M])
            metal += _railing(high, low)
    return Piece("footbridge", ((merged(concrete), STONE), (merged(metal), GREEN_METAL)))


def _stairs(y: float, top: float) -> list[Mesh]:
    rise, run = (top - KERB_M) / _STEPS, STAIRS_M / _STEPS
    return [
        slab((run + 0.06, 1.4, 0.2), (WIDTH_M / 2 + (k + 0.5) * run, y, top - (k + 1) * rise - 0.05))
        for k in range(_STEPS)
    ]


def _railing(start: np.ndarray, end: np.ndarray) -> list[Mesh]:
    up = np.array([0.0, 0, 1])
    rails = [tube([start + up * z, end + up * z], 0.03, sides=4) for z in (_RAIL_M, 0.55 * _RAIL_M)]
    count = max(2, round(float(np.linalg.norm(end - start)) / 1.3))
    posts = [
        tube(np.array([at, at + up * _RAIL_M]), 0.025, sides=3) for at in np.linspace(start, end, count + 1)
    ]
    return rails + posts
