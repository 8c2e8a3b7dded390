"""The even parts of a capture in cells of some pixels, and what is left there beside smooth light."""

from __future__ import annotations

from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from tacos_gap.captures import RealCapture
from tacos_gap.captures.targets.wall import smooth_terms
from tacos_gap.statistics.grid import smooth_areas

CELL_PX = 4
"""Side of a cell: a whole number of those of a colour mosaic, whose mean is of no colour."""

_FITTED_EACH = 3  # one cell in so many along both axes says what the smooth light is


def _in_cells(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """(H / CELL_PX, W / CELL_PX, C) means of cells of an (H, W, C) image; what fills no cell is left out."""
    import cv2

    height, width, channels = image.shape
    rows, columns = height // CELL_PX, width // CELL_PX
    whole = image[: rows * CELL_PX, : columns * CELL_PX]
    small = cv2.resize(whole, (columns, rows), interpolation=cv2.INTER_AREA)
    return np.asarray(small, np.float32).reshape(rows, columns, channels)


@dataclass(frozen=True, eq=False)
class EvenCells:
    """Even part of a capture, in cells of `CELL_PX`."""

    whole: NDArray[np.float32]  # (h, w, 1) 1 of cells that are even as a whole, else 0
    smooth: NDArray[np.float32]  # (h w, T) terms of smooth light in those cells
    estimator: NDArray[np.float32]  # (T, k) least squares of them, from the cells `few`
    few: NDArray[np.int64]  # (k,) flat indices of cells

    @classmethod
    def of(cls, capture: RealCapture) -> EvenCells:
        """Of the pixels that count and where no edges are expected."""
        even = (smooth_areas(capture) & capture.valid).astype(np.float32)[..., None]
        whole = np.floor(_in_cells(even) + np.float32(1e-3))
        smooth = smooth_terms(whole.shape[:2]) * whole.reshape(-1, 1)
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


_KEPT: WeakKeyDictionary[RealCapture, EvenCells] = WeakKeyDictionary()


def even_cells(capture: RealCapture) -> EvenCells:
    """Worked out once per capture."""
    if capture not in _KEPT:
        _KEPT[capture] = EvenCells.of(capture)
    return _KEPT[capture]
