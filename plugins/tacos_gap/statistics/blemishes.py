"""Blemishes: what repeats from frame to frame, wider than a few pixels and narrower than a tile.

Dust on the cover glass, fingerprints and stains of a sensor are of this size: too wide for the high-pass that
fixed patterns are measured behind, and lost in the mean of a tile.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from tacos_gap.statistics.block import Sample, StatisticBlock, mean_signal
from tacos_gap.statistics.even_cells import CELL_PX, even_cells
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
    if not sample.repeats or capture.kind not in ("dark", "flat", "bracket") or not has_even_areas(capture):
        return
    even = even_cells(capture)
    whole = even.whole
    one, other = (even.without_smooth(half) for half in sample.halves)
    for size_px in SIZES_PX:
        counted = _counted(whole, size_px[1])
        if not counted.any():
            continue
        product = _band(one, whole, size_px) * _band(other, whole, size_px)
        nearby = _mean_around(product * counted[..., None], sum(size_px) // 2)
        for channel, name in enumerate(sample.channels):
            values = np.array([product[counted, channel].mean(), nearby[counted, channel].max()], np.float64)
            level = mean_signal(capture)[channel]
            amplitude = np.hypot(RELATIVE * level, OFFSET_DN) * np.array([1.0, AT_ITS_STRONGEST])
            margin = np.hypot(amplitude**2, LUCK * np.abs(values))
            at = [{"size_px": list(size_px), "of": of, "channel": name} for of in ("all", "strongest")]
            yield StatisticBlock("blemishes", "pixel", values, at, margin)


def _mean_around(cells: NDArray[np.float32], size_px: int) -> NDArray[np.float32]:
    """Mean of a square of this side around each cell; the cell itself where that is its own."""
    import cv2

    side = size_px // CELL_PX
    return cells if side == 1 else np.asarray(cv2.blur(cells, (side, side)), np.float32).reshape(cells.shape)


def _band(
    cells: NDArray[np.float32], whole: NDArray[np.float32], size_px: tuple[int, int]
) -> NDArray[np.float32]:
    """What is wider than one size and narrower than the other, of cells that are whole."""
    finer, coarser = (
        _mean_around(cells, size) / np.maximum(_mean_around(whole, size), 1e-6) for size in size_px
    )
    return np.asarray(finer - coarser, np.float32)


def _counted(whole: NDArray[np.float32], widest_px: int) -> NDArray[np.bool_]:
    """(h, w) whole cells whose widest square lies in the picture, and mostly in areas that are even."""
    border = widest_px // CELL_PX // 2
    counted = (_mean_around(whole, widest_px)[..., 0] >= _LEAST_COUNTED) & (whole[..., 0] > 0)
    rows, columns = counted.shape
    inside = np.zeros((rows, columns), bool)
    inside[border : rows - border, border : columns - border] = True
    return np.asarray(counted & inside)
