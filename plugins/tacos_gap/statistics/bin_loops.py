"""Sums over bins of pixels, compiled; imported late, as numba takes a while."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tacos_plugins.compiled.loops import compiled


@compiled
def add_up(bins: NDArray[np.int32], image: NDArray[np.float32], sums: NDArray[np.float64]) -> None:
    """Add the pixels of an image to the sums of their bins.

    `bins`: (H, W) the bin of each pixel, from 0 on. `sums`: (B,) to which they are added.
    """
    for row in range(image.shape[0]):
        for column in range(image.shape[1]):
            sums[bins[row, column]] += image[row, column]
