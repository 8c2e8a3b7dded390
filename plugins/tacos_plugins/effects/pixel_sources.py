"""Inverse of a motion of pixels of which only the way there is known."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tacos_framework import ImageGeometry
from tacos_framework.camera import Places

_ROUNDS = 6
_CLOSE_PX = 1e-4


def source_of(geometry: ImageGeometry, forward: Callable[..., Places], frames: int) -> Places:
    """Places that the pixels of a moved image come from, by the way there.

    `forward`: takes columns and rows, (N, H, W), to where they move [px].

    Returns: (N, H, W) columns and rows that `forward` takes to the pixels [px]. Where a near surface has
    uncovered a far one, the rim of either is drawn out.
    """
    size = (frames, geometry.height_px, geometry.width_px)
    to_x = np.broadcast_to(np.arange(geometry.width_px, dtype=np.float64), size)
    to_y = np.broadcast_to(np.arange(geometry.height_px, dtype=np.float64)[:, None], size)
    x, y = to_x, to_y
    for _ in range(_ROUNDS):
        there_x, there_y = forward(x, y)
        left_x, left_y = to_x - there_x, to_y - there_y
        x, y = x + left_x, y + left_y
        if max(np.abs(left_x).max(), np.abs(left_y).max()) < _CLOSE_PX:
            break
    return x, y
