"""Cells of a mosaic, in which every colour stands once: what it shows whatever the colours."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def cell_means(image: NDArray[Any]) -> NDArray[np.float32]:
    """(H // 2, W // 2) means of the 2 x 2 cells of an (H, W) mosaic: what it shows, whatever the colours."""
    height, width = (side // 2 * 2 for side in image.shape)
    cells = image[:height, :width].reshape(height // 2, 2, width // 2, 2)
    return np.ascontiguousarray(cells.mean(axis=(1, 3)), np.float32)


def of_pixels(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """(2, 3) affine map of the points of `cell_means` as a map of the points of the mosaic."""
    linear, moved = matrix[:, :2], matrix[:, 2]
    middle = np.array([0.5, 0.5])
    return np.column_stack([linear, 2 * moved + middle - linear @ middle])
