"""Blemishes: what repeats from frame to frame, wider than a few pixels and narrower than a tile.

Dust on the cover glass, fingerprints and stains of a sensor are of this size: too wide for the high-pass that
fixed patterns are measured behind, and lost in the mean of a tile.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from tacos_gap.statistics.block import Sample, StatisticBlock, mean_signal
from tacos_gap.statistics.even_cells import CELL_PX, EvenCells, even_cells
from tacos_gap.statistics.grid import has_even_areas

SIZES_PX = ((4, 20), (20, 60))
"""Sizes of blemishes: what is wider than the one and narrower than the other."""

RELATIVE = 0.003
OFFSET_DN = 0.06
"""Equivalence margins of a blemish that is everywhere: of its rms over the level, and in the dark."""

AT_ITS_STRONGEST = 3.0
"""A single one may be so many times stronger than one that is everywhere."""

LUCK = 0.3
"""Share of a pattern's own strength by which two that are drawn alike differ in so few places."""

_LEAST_COUNTED = 0.5  # share of a window that is even, for a place to count


def blemish_statistics(sample: Sample) -> Iterator[StatisticBlock]:
    """Covariance of independent halves of the frames in bands of size, over the image and at its largest."""
    capture = sample.capture
    if not (sample.repeats and capture.shows_patterns and has_even_areas(capture)):
        return
    even = even_cells(capture)
    one, other = (even.without_smooth(half) for half in sample.halves)
    for looked in _looked_for(even):
        if not looked.places.size:
            continue
        product = looked.band(one) * looked.band(other)
        nearby = _mean_around(product * looked.counted, sum(looked.size_px) // 2)
        for channel, name in enumerate(sample.channels):
            here, around = (looked.counting(cells, channel) for cells in (product, nearby))
            values = np.array([here.mean(), around.max()], np.float64)
            level = mean_signal(capture)[channel]
            amplitude = np.hypot(RELATIVE * level, OFFSET_DN) * np.array([1.0, AT_ITS_STRONGEST])
            margin = np.hypot(amplitude**2, LUCK * np.abs(values))
            at = [{"size_px": list(looked.size_px), "of": of, "channel": name} for of in ("all", "strongest")]
            yield StatisticBlock("blemishes", "pixel", values, at, margin)


@dataclass(frozen=True, eq=False)
class _Looked:
    """Cells where blemishes of a size are looked for."""

    size_px: tuple[int, int]  # what is wider than the one and narrower than the other
    around: tuple[NDArray[np.float32], NDArray[np.float32]]
    """(h, w, 1) share of the square around each cell that is even, for either size."""
    counted: NDArray[np.float32]  # (h, w, 1) 1 of cells that count, else 0
    places: NDArray[np.int64]  # (M,) flat indices of those

    @classmethod
    def of(cls, whole: NDArray[np.float32], size_px: tuple[int, int]) -> _Looked:
        """Of (h, w, 1) cells that are `whole`."""
        finer, coarser = (np.maximum(_mean_around(whole, size), 1e-6) for size in size_px)
        counted = _counted(whole, size_px[1])
        return cls(size_px, (finer, coarser), counted[..., None].astype(np.float32), np.flatnonzero(counted))

    def band(self, cells: NDArray[np.float32]) -> NDArray[np.float32]:
        """(h, w, C) what is wider than one size and narrower than the other, of cells that are whole."""
        finer, coarser = (
            _mean_around(cells, size) / around for size, around in zip(self.size_px, self.around, strict=True)
        )
        return np.asarray(finer - coarser, np.float32)

    def counting(self, cells: NDArray[np.float32], channel: int) -> NDArray[np.float32]:
        """(M,) those of the cells that count, of a channel."""
        return np.take(cells[..., channel], self.places)


_LOOKED: WeakKeyDictionary[EvenCells, tuple[_Looked, ...]] = WeakKeyDictionary()


def _looked_for(even: EvenCells) -> tuple[_Looked, ...]:
    """Worked out once per capture."""
    if even not in _LOOKED:
        _LOOKED[even] = tuple(_Looked.of(even.whole, size_px) for size_px in SIZES_PX)
    return _LOOKED[even]


def _mean_around(cells: NDArray[np.float32], size_px: int) -> NDArray[np.float32]:
    """Mean of a square of this side around each cell; the cell itself where that is its own."""
    import cv2

    side = size_px // CELL_PX
    return cells if side == 1 else np.asarray(cv2.blur(cells, (side, side)), np.float32).reshape(cells.shape)


def _counted(whole: NDArray[np.float32], widest_px: int) -> NDArray[np.bool_]:
    """(h, w) whole cells whose widest square lies in the picture, and mostly in areas that are even."""
    border = widest_px // CELL_PX // 2
    counted = (_mean_around(whole, widest_px)[..., 0] >= _LEAST_COUNTED) & (whole[..., 0] > 0)
    rows, columns = counted.shape
    inside = np.zeros((rows, columns), bool)
    inside[border : rows - border, border : columns - border] = True
    return np.asarray(counted & inside)
