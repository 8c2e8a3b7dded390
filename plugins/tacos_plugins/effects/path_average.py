"""Arrays made for the loops of `path_loops`, and filled by them."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from numpy.typing import NDArray

from tacos_plugins.effects.image_paths import Paths
from tacos_plugins.effects.path_loops import (
    KERNEL_PX,
    LANES,
    MOST_AT_ONCE_PX,
    PHASES,
    average_along,
    find_shown,
)


def along_paths(
    frame: NDArray[np.floating], near: NDArray[np.float32], table_of: NDArray[np.int32], paths: Paths
) -> NDArray[np.float32]:
    """(H, W, C) light averaged along the path of each pixel, one straight part after the other.

    Parameters
    ----------
    frame
        (H, W, C) light, C at most 3.
    near, table_of
        (H, W) inverse depth [1/m] and number of the table of what each pixel shows.

    Returns
    -------
    NDArray
        Nowhere outside the range of the frame.
    """
    margin = math.ceil(paths.reach_px) + 2 * KERNEL_PX + MOST_AT_ONCE_PX
    image = np.pad(frame.astype(np.float32, copy=False), ((margin, margin), (margin, margin), (0, 0)), "edge")
    mean, part = np.zeros((2, frame.size + LANES), np.float32)
    nodes, scratch = np.empty(paths.row_shape, np.float32), np.empty((2, 4), np.float32)
    for table in paths.parts:
        grid = (table, paths.spacing_px, paths.widest, paths.alike)
        average_along(image, margin, near, table_of, *grid, nodes, _taps(), scratch, part)
        mean += part
    mean *= np.float32(1 / len(paths.parts))
    return np.clip(mean, frame.min(), frame.max(), out=mean)[: frame.size].reshape(frame.shape)


@cache
def _taps() -> NDArray[np.float32]:
    """(PHASES + 1, 4) the cubic kernel (Keys 1981) at t + 1, t, 1 - t and 2 - t, for t from 0 to 1."""
    t = np.linspace(0, 1, PHASES + 1)
    inner, outer = (lambda t: 1 + t**2 * (1.5 * t - 2.5)), (lambda t: -0.5 * t * (1 - t) ** 2)
    return np.stack([outer(t), inner(t), inner(1 - t), outer(1 - t)], axis=1).astype(np.float32)


def shown_at(
    near: NDArray[np.float32], table_of: NDArray[np.int32], middle: Paths
) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """(H, W) which pixel of the frame, row by row, each shows at its row's moment, and its inverse depth.

    Parameters
    ----------
    near, table_of
        Of the frame, as above.
    """
    shown, moved = np.empty(near.shape, np.int32), np.empty_like(near)
    nodes = np.empty(middle.row_shape, np.float32)
    grid = (middle.parts[0], middle.spacing_px, middle.widest, middle.alike)
    find_shown(near, table_of, *grid, nodes, shown, moved)
    return shown, moved
