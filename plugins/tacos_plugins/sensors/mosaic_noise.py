"""Noise of a mosaic's colours where several of the camera's pixels are averaged into one."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

FILTERED = 1 / 3
"""Light that passes a colour filter, over that which reaches a photosite without one.

RED Digital Cinema, "Color vs. monochrome sensors": a pixel under filters captures a third of the light. It
is the middle of the 2 to 4 times that sensors with unfiltered photosites beside filtered ones are said to
gain (Compton and Hamilton 2007, "Color Filter Array 2.0", Eastman Kodak).
"""

_CORNERS = np.outer([0.5, 1.0, 0.5], [0.5, 1.0, 0.5])
_CROSS = np.array([[0.0, 0.25, 0.0], [0.25, 1.0, 0.25], [0.0, 0.25, 0.0]])


@lru_cache(maxsize=64)
def averaged_variances(binning: float) -> tuple[float, float, float]:
    """Variance of red, green and blue, averaged over b x b pixels of a mosaic, over that of one photosite.

    Missing colours are means of their neighbours, so that a channel is its photosites, a share n of all,
    convolved with a kernel k. Averaged over the places of a block in the pattern, its covariance at a
    distance d is n (k * k)(d), and the mean over a block of b pixels along each side has the variance

        n sum_d (k * k)(d) w(d_x) w(d_y),    w(d) = max(b - |d|, 0) / b^2.

    Large blocks have n b^2 photosites of their own; small ones share some with their neighbours. It is exact
    for whole b, and within 5 % between them.

    >>> [round(each, 3) for each in averaged_variances(1)]
    [0.562, 0.625, 0.562]
    >>> [round(100**2 * each, 1) for each in averaged_variances(100)]
    [3.9, 2.0, 3.9]
    """
    red = 0.25 * _of_mean(_CORNERS, binning)
    return red, 0.5 * _of_mean(_CROSS, binning), red


def _of_mean(kernel: NDArray[np.float64], binning: float) -> float:
    reach = np.arange(-2, 3)
    padded = np.pad(kernel, 2)
    covariance = np.array([[np.sum(padded * np.roll(padded, (y, x), (0, 1))) for x in reach] for y in reach])
    weights = np.maximum(binning - np.abs(reach), 0) / binning**2
    return float(weights @ covariance @ weights)
