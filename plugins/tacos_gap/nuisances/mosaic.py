"""Pictures behind mosaics: neighbours have other colours, so each of the four planes is a picture by itself.

A point p of the file is the point (p - o) / 2 of the plane that begins at o, x and y alike.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.float32]

_ORIGINS = ((0, 0), (1, 0), (0, 1), (1, 1))  # x, y of the first pixel of each plane


def of_each_plane(frame: Image, change: Callable[[Image, NDArray[np.float64]], Image]) -> Image:
    """A mosaic whose planes were changed one by one.

    Parameters
    ----------
    frame
        (H, W, 1) the mosaic.
    change
        Called with each plane and its origin (x, y) in the mosaic.
    """
    changed = np.empty_like(frame)
    for x, y in _ORIGINS:
        changed[y::2, x::2] = change(np.ascontiguousarray(frame[y::2, x::2]), np.array([x, y], float))
    return changed


def in_plane(matrix: NDArray[np.float64], origin: NDArray[np.float64]) -> NDArray[np.float64]:
    """(2, 3) affine map of the points of a mosaic as a map of the points of one of its planes."""
    linear, moved = matrix[:, :2], matrix[:, 2]
    return np.column_stack([linear, (linear @ origin + moved - origin) / 2])


def cell_means(image: NDArray[Any]) -> Image:
    """(H // 2, W // 2) means of the 2 x 2 cells of an (H, W) mosaic: what it shows, whatever the colours."""
    height, width = (side // 2 * 2 for side in image.shape)
    cells = image[:height, :width].reshape(height // 2, 2, width // 2, 2)
    return np.ascontiguousarray(cells.mean(axis=(1, 3)), np.float32)


def of_pixels(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """(2, 3) affine map of the points of `cell_means` as a map of the points of the mosaic.

    The middle of a cell is half a pixel beyond its first one.
    """
    linear, moved = matrix[:, :2], matrix[:, 2]
    middle = np.array([0.5, 0.5])
    return np.column_stack([linear, 2 * moved + middle - linear @ middle])
