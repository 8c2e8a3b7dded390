"""What of an image of half pixels is known to be covered, so that what lies behind can be passed over.

Of each block of a row it is kept how far away its farthest sample is at most: a triangle that covers a whole
block says so from its two ends, as inverse depth is linear in the image. After Greene, Kass and Miller,
"Hierarchical Z-buffer visibility", SIGGRAPH 1993, with rows for tiles.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tacos_framework.compiled import compiled

BLOCK = 64
"""Samples of a row in a block [px]."""


def nothing_drawn(shape: tuple[int, ...]) -> NDArray[np.float32]:
    """What `draw` keeps of an (H, W) image in which nothing is drawn yet, as its `lowest`."""
    height, width = shape
    return np.zeros((height, -(-width // BLOCK)), np.float32)


@compiled
def along(row: NDArray[np.float64], x: float, y: float, z: float) -> float:
    """Place of a point along one axis of the image, of its (4,) row of the projection."""
    return row[0] * x + row[1] * y + row[2] * z + row[3]


@compiled
def is_hidden(
    lowest: NDArray[np.float32], first: int, last: int, least: int, most: int, nearest: float | np.float32
) -> bool:
    """Whether what is drawn already lies before all that could be seen in some rows and columns."""
    for y in range(first, last + 1):
        for block in range(least // BLOCK, most // BLOCK + 1):
            if lowest[y, block] < nearest:
                return False
    return True


@compiled
def box_is_hidden(
    lowest: NDArray[np.float32],
    box_m: NDArray[np.float64],
    pixel_from_world: NDArray[np.float64],
    first_row: int,
    width: int,
    near_m: float,
) -> bool:
    """Whether a box with (2, 3) corners lies behind what is drawn already, or beside it."""
    least, most, first, last, nearest = np.inf, -np.inf, np.inf, -np.inf, 0.0
    for corner in range(8):
        x, y, z = box_m[corner & 1, 0], box_m[corner >> 1 & 1, 1], box_m[corner >> 2, 2]
        u, v = along(pixel_from_world[0], x, y, z), along(pixel_from_world[1], x, y, z)
        w = along(pixel_from_world[2], x, y, z)
        if w < near_m:
            return False
        least, most = min(least, u / w), max(most, u / w)
        first, last = min(first, v / w), max(last, v / w)
        nearest = max(nearest, 1 / w)
    # Corners are rounded to parts of a sample, and inverse depths to single precision.
    rows = max(int(np.floor(first)) - first_row, 0), min(int(np.ceil(last)) - first_row, len(lowest) - 1)
    columns = max(int(np.floor(least)), 0), min(int(np.ceil(most)), width - 1)
    return is_hidden(lowest, *rows, *columns, nearest * (1 + 1e-6))
