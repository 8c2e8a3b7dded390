"""Covered parts of an image of half pixels, behind which nothing need be drawn.

Of each block of a row it is kept how far away its farthest sample is at most: a triangle that covers a whole
block says so from its two ends, as inverse depth is linear in the image. After Greene, Kass and Miller,
"Hierarchical Z-buffer visibility", SIGGRAPH 1993, with rows for tiles.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tacos_plugins.compiled.loops import compiled

BLOCK = 64
"""Samples of a row in a block [px]."""


def nothing_drawn(shape: tuple[int, ...]) -> NDArray[np.float32]:
    """The `lowest` that `draw` keeps of an (H, W) image in which nothing is drawn yet, as its `lowest`."""
    height, width = shape
    return np.zeros((height, -(-width // BLOCK)), np.float32)


@compiled
def is_hidden(
    lowest: NDArray[np.float32], first: int, last: int, least: int, most: int, nearest: float | np.float32
) -> bool:
    """True if what is drawn already lies before all that could be seen in some rows and columns."""
    for y in range(first, last + 1):
        for block in range(least // BLOCK, most // BLOCK + 1):
            if lowest[y, block] < nearest:
                return False
    return True
