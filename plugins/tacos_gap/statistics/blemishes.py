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

from tacos_gap.captures import RealCapture
from tacos_gap.statistics.block import Sample, StatisticBlock, mean_signal
from tacos_gap.statistics.grid import has_even_areas, smooth_areas

CELL_PX = 4
"""Pixels are averaged over squares of this side first: a whole number of cells of a colour mosaic."""

SIZES_PX = ((4, 20), (20, 60))
"""Sizes of blemishes: what is wider than the one and narrower than the other."""

RELATIVE = 0.003
OFFSET_DN = 0.06
"""Equivalence margins of a blemish that is everywhere: of its rms over the level, and in the dark."""

AT_ITS_STRONGEST = 3.0
"""A single one may be so many times stronger than one that is everywhere."""

LUCK = 0.3
"""Share of a pattern's own strength by which two that are drawn alike differ in so few places."""

SMOOTH_DEGREE = 4
"""Degree of the surface that is taken for smooth light."""

_FITTED_EACH = 3  # every so manieth cell along both axes says what the smooth light is
_LEAST_COUNTED = 0.5  # share of a window that is even, for a place to count


def blemish_statistics(sample: Sample) -> Iterator[StatisticBlock]:
    """Covariance of independent halves of the frames in bands of size, over the image and at its largest."""
    capture = sample.capture
    if not sample.repeats or capture.kind not in ("dark", "flat", "bracket") or not has_even_areas(capture):
        return
    even = _even_in(capture)
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


@dataclass(frozen=True, eq=False)
class _Even:
    """What of a capture is even, in cells.

    Parameters
    ----------
    whole
        (h, w, 1) 1 of cells that are even as a whole, else 0.
    smooth
        (h w, T) terms of smooth light in those cells.
    estimator
        (T, k) least squares of them, from the cells `few`.
    few
        (k,) flat indices of cells.
    """

    whole: NDArray[np.float32]
    smooth: NDArray[np.float32]
    estimator: NDArray[np.float32]
    few: NDArray[np.int64]

    @classmethod
    def of(cls, capture: RealCapture) -> _Even:
        even = (smooth_areas(capture) & capture.valid).astype(np.float32)[..., None]
        whole = np.floor(_in_cells(even) + np.float32(1e-3))
        rows, columns = (np.linspace(-1, 1, size) for size in whole.shape[:2])
        degrees = range(SMOOTH_DEGREE + 1)
        terms = [np.multiply.outer(rows**i, columns**j) for i in degrees for j in degrees if i + j in degrees]
        smooth = (np.stack(terms, axis=-1) * whole).reshape(whole.size, -1)
        index = np.arange(whole.size).reshape(whole.shape[:2])
        few = index[::_FITTED_EACH, ::_FITTED_EACH].ravel()
        return cls(whole, smooth.astype(np.float32), np.linalg.pinv(smooth[few]).astype(np.float32), few)

    def without_smooth(self, image: NDArray[np.float32]) -> NDArray[np.float32]:
        """(h, w, C) means of cells less the smooth light: what falls off with the radius is no blemish."""
        cells = _in_cells(image) * self.whole
        flat = cells.reshape(self.whole.size, -1)
        return np.asarray(flat - self.smooth @ (self.estimator @ flat[self.few]), np.float32).reshape(
            cells.shape
        )


_EVEN: WeakKeyDictionary[RealCapture, _Even] = WeakKeyDictionary()


def _even_in(capture: RealCapture) -> _Even:
    """Worked out once per capture."""
    if capture not in _EVEN:
        _EVEN[capture] = _Even.of(capture)
    return _EVEN[capture]


def _in_cells(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """(H / CELL_PX, W / CELL_PX, C) means of cells of an (H, W, C) image; what fills no cell is left out."""
    import cv2

    height, width, channels = image.shape
    rows, columns = height // CELL_PX, width // CELL_PX
    whole = image[: rows * CELL_PX, : columns * CELL_PX]
    small = cv2.resize(whole, (columns, rows), interpolation=cv2.INTER_AREA)
    return np.asarray(small, np.float32).reshape(rows, columns, channels)


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
