"""Arrays made for the loops of `path_loops`, and filled by them."""

from __future__ import annotations

import math
from dataclasses import dataclass
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


@dataclass(frozen=True, eq=False)
class Shown:
    """Things that pixels of a rolling shutter show at the moment of their row."""

    near: NDArray[np.float32]
    table_of: NDArray[np.int32]
    """(H, W) its inverse depth in the frame [1/m], and the number of its table."""
    depth_m: NDArray[np.float32]
    object_id: NDArray[np.int32]
    """(H, W) its depth then [m], and its object."""

    @classmethod
    def at(
        cls,
        near: NDArray[np.float32],
        table_of: NDArray[np.int32],
        object_id: NDArray[np.int32],
        middle: Paths,
    ) -> Shown:
        """By the (H, W) arrays of the frame and where things are in the middle of each row's exposure."""
        size = near.shape
        shown = cls(
            near=np.empty(size, np.float32),
            table_of=np.empty(size, np.int32),
            depth_m=np.empty(size, np.float32),
            object_id=np.empty(size, np.int32),
        )
        nodes = np.empty(middle.row_shape, np.float32)
        grid = (middle.parts[0], middle.spacing_px, middle.widest, middle.alike)
        filled = (shown.near, shown.table_of, shown.depth_m, shown.object_id)
        find_shown(near, table_of, object_id, *grid, nodes, *filled)
        return shown


def along_paths(
    frame: NDArray[np.floating], near: NDArray[np.float32], table_of: NDArray[np.int32], paths: Paths
) -> NDArray[np.float32]:
    """(H, W, C) light averaged along the path of each pixel, one straight part after the other.

    `frame`: (H, W, C) light, C at most 3. `near`, `table_of`: (H, W) inverse depth [1/m] and number of the
    table of what each pixel shows.

    Returns: nowhere outside the range of the frame.
    """
    frame = frame.astype(np.float32, copy=False)
    margin = math.ceil(paths.reach_px) + 2 * KERNEL_PX + MOST_AT_ONCE_PX
    image = np.pad(frame, ((margin, margin), (margin, margin), (0, 0)), "edge")
    nodes, scratch = np.empty(paths.row_shape, np.float32), np.empty((2, 4), np.float32)
    kernel = (_taps(), scratch, frame.min(), frame.max())
    total, filled = np.zeros(frame.size, np.float32), np.empty(frame.size + LANES, np.float32)
    for part in paths.parts:
        grid = (part, paths.spacing_px, paths.widest, paths.alike)
        average_along(image, margin, near, table_of, *grid, nodes, *kernel, filled)
        total += filled[: frame.size]
    total /= len(paths.parts)
    return total.reshape(frame.shape)


@cache
def _taps() -> NDArray[np.float32]:
    """(PHASES + 1, 4) the cubic kernel (Keys 1981) at t + 1, t, 1 - t and 2 - t, for t from 0 to 1."""
    t = np.linspace(0, 1, PHASES + 1)
    inner, outer = (lambda t: 1 + t**2 * (1.5 * t - 2.5)), (lambda t: -0.5 * t * (1 - t) ** 2)
    return np.stack([outer(t), inner(t), inner(1 - t), outer(1 - t)], axis=1).astype(np.float32)
