"""Pictures on free stretches of wall."""

from __future__ import annotations

import numpy as np

from tacos_worlds.indoor.structure.sides import Side
from tacos_worlds.kit.finishes import BLACK_METAL, BRASS, Finish, Style
from tacos_worlds.kit.piece import BACKGROUND, Piece
from tacos_worlds.kit.shapes import panel, slab


def hang_pictures(
    rng: np.random.Generator, side: Side, busy_m: list[tuple[float, float]], style: Style, count: int
) -> list[Piece]:
    """Up to `count` pictures on a side, clear of windows, doors and tall furniture."""
    found: list[Piece] = []
    busy = list(busy_m)
    for _ in range(count * 6):
        if len(found) == count:
            break
        width = rng.uniform(0.4, 1.0)
        height = width * rng.choice([0.7, 0.75, 1.0, 1.35]) if width < 0.7 else width * rng.choice([0.6, 0.7])
        at = rng.uniform(0.3 + width / 2, max(side.length_m - 0.3 - width / 2, 0.3 + width / 2 + 0.01))
        low, high = at - width / 2 - 0.12, at + width / 2 + 0.12
        if any(low < end and start < high for start, end in busy):
            continue
        busy.append((low, high))
        found.append(
            side.place(_picture(rng, style, width, height), at, 0.0, rng.uniform(1.5, 1.65) - height / 2)
        )
    return found


def _picture(rng: np.random.Generator, style: Style, width: float, height: float) -> Piece:
    rim = rng.uniform(0.018, 0.04)
    wood = [style.wood, style.second_wood, BLACK_METAL, BRASS][int(rng.integers(4))]
    motif = str(rng.choice(["landscape", "landscape", "abstract", "photograph"]))
    canvas = Finish(motif, variant=int(rng.integers(3)), texture_size_m=max(width, height), roughness=0.6)
    parts = [(slab((width, 0.012, height), (0, 0.008, 0)), wood)]
    for z in (0.0, height - rim):
        parts.append((slab((width, 0.026, rim), (0, 0.016, z)), wood))
    for x in (-1, 1):
        parts.append((slab((rim, 0.026, height), (x * (width - rim) / 2, 0.016, 0)), wood))
    inner = (width - 2 * rim, height - 2 * rim)
    face = panel([width / 2 - rim, 0.0155, rim], [-inner[0], 0, 0], [0, 0, inner[1]], step_m=1.0)
    parts.append((face, canvas))
    return Piece(BACKGROUND, tuple(parts))
