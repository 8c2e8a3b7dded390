"""Tiles of an image with texture, which tells where they went."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from tacos_gap.captures import RealCapture
from tacos_gap.statistics.grid import tiles

_LEAST_PIXELS, _MOST_PIXELS = 40, 1_500
"""Textured pixels that a tile has at least, and at most: the steepest, in half the time, miss its move by a
third more, a hundredth of a pixel of a circuit board with noise."""

_REACH_PX = 4
"""How far from a pixel its smoothed slope looks."""

_TEXTURED = 0.02
"""Gradient that makes a pixel count, over the range of the image per pixel."""


@dataclass(frozen=True, eq=False)
class TexturedTiles:
    """Textured pixels, tile by tile. `parts`: the pixels of each tile, as flat indices."""

    parts: Sequence[NDArray[np.int64]]
    at: Sequence[Mapping[str, Any]]

    @cached_property
    def middles_px(self) -> NDArray[np.float64]:
        """(T, 2) middles of the tiles [px]."""
        boxes = np.array([at["box_px"] for at in self.at], float).reshape(-1, 2, 2)
        return np.asarray(boxes.mean(axis=1))

    def medians(self, field: NDArray[np.float32]) -> NDArray[np.float64]:
        """(2, T) medians of both components of an (H, W, 2) field in each tile."""
        flat = np.ascontiguousarray(field.reshape(-1, 2).T)
        of_tiles = (np.take(flat, part, axis=1) for part in self.parts)
        middles = [np.partition(tile, tile.shape[1] // 2)[:, tile.shape[1] // 2] for tile in of_tiles]
        return np.array(middles, np.float64).reshape(-1, 2).T

    def centred(
        self, images: NDArray[np.float32], moved_px: NDArray[np.int64] | None = None
    ) -> NDArray[np.float64]:
        """(I, P) pixels of (I, H, W) images, tiles of which may be moved, less the mean of their tile."""
        flat = images.reshape(len(images), -1)
        if moved_px is None or not moved_px.any():
            values = np.take(flat, self._pixels, axis=1).astype(np.float64)
        else:
            height, width = images.shape[1:]
            rows, columns = np.divmod(self._pixels, width)
            columns = np.clip(columns - self.spread(moved_px[0]), 0, width - 1)
            rows = np.clip(rows - self.spread(moved_px[1]), 0, height - 1)
            values = np.take(flat, rows * width + columns, axis=1).astype(np.float64)
        values -= self.spread(self.sums(values) / self._counts)
        return values

    def sums(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """(..., T) sums of (..., P) values over tiles."""
        return np.asarray(np.add.reduceat(values, self._starts, axis=-1))

    def spread(self, values: NDArray[Any]) -> NDArray[Any]:
        """(..., P) the value of its tile for each pixel, of (..., T) values."""
        return np.repeat(values, self._counts, axis=-1)

    @cached_property
    def _pixels(self) -> NDArray[np.int64]:
        return np.concatenate(self.parts)

    @cached_property
    def _counts(self) -> NDArray[np.int64]:
        return np.array([len(part) for part in self.parts])

    @cached_property
    def _starts(self) -> NDArray[np.int64]:
        return np.cumsum([0, *self._counts[:-1]])


_KEPT: WeakKeyDictionary[RealCapture, TexturedTiles] = WeakKeyDictionary()


def textured_tiles(capture: RealCapture) -> TexturedTiles:
    """Those of what is expected of a capture; worked out once."""
    if capture not in _KEPT:
        assert capture.expected_dn is not None
        level = capture.expected_dn[0].mean(axis=-1)
        gy, gx = np.gradient(level)
        slope = np.hypot(gx, gy)
        textured = (slope > _TEXTURED * max(np.ptp(level), 1)) & _well_inside(capture.valid)
        grid = tiles(capture)
        where = np.flatnonzero(textured)
        tile = grid.index.ravel()[where]
        parts = [_steepest(where[tile == k], slope.ravel()) for k in range(len(grid.at))]
        kept = [k for k, part in enumerate(parts) if len(part) > _LEAST_PIXELS]
        _KEPT[capture] = TexturedTiles([parts[k] for k in kept], [grid.at[k] for k in kept])
    return _KEPT[capture]


def _steepest(pixels: NDArray[np.int64], slope: NDArray[np.float32]) -> NDArray[np.int64]:
    """The steepest of a tile's pixels, in their order, as many as tell its move."""
    if len(pixels) <= _MOST_PIXELS:
        return pixels
    return np.sort(pixels[np.argpartition(slope[pixels], -_MOST_PIXELS)[-_MOST_PIXELS:]])


def _well_inside(valid: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(H, W) whether all pixels that a slope is made of are valid, and in the picture.

    An edge that is mirrored at the border bends there, and seems to say how far it moved along itself.
    """
    import cv2

    around = np.ones((2 * _REACH_PX + 1,) * 2, np.uint8)
    eroded = cv2.erode(valid.astype(np.uint8), around, borderType=cv2.BORDER_CONSTANT, borderValue=0)
    return np.asarray(eroded, bool)
