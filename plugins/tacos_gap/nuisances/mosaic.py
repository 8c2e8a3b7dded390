"""Pictures behind mosaics: neighbours have other colours, so each of the four planes is a picture by itself.

A point p of the file is the point (p - o) / 2 of the plane that begins at o, x and y alike.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from tacos_framework.camera import Places, resample

Image = NDArray[np.float32]

_ORIGINS = ((0, 0), (1, 0), (0, 1), (1, 1))  # x, y of the first pixel of each plane


def of_each_plane(frame: Image, change: Callable[[Image], Image]) -> Image:
    changed = np.empty_like(frame)
    for x, y in _ORIGINS:
        changed[y::2, x::2] = change(np.ascontiguousarray(frame[y::2, x::2]))
    return changed


def resampled_mosaic(frames: Image, source: Places) -> Image:
    """(N, H, W, 1) mosaics whose photosites look elsewhere, each among those of its own colour.

    `frames`: (N, H, W, 1) mosaics. `source`: (H, W) or (N, H, W) columns and rows of the mosaic where its
    photosites look [px].
    """
    moved = np.empty_like(frames)
    for x, y in _ORIGINS:
        columns, rows = ((places[..., y::2, x::2] - o) / 2 for places, o in zip(source, (x, y), strict=True))
        moved[:, y::2, x::2] = resample(frames[:, y::2, x::2], columns, rows)
    return moved
