"""Fixed patterns: spatial variances of a stack of frames.

Source: EMVA Standard 1288, Release 4.0 Linear, Sec. 8: the variance of the mean over L frames, less the
temporal variance over L; rows, columns and pixels apart.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from tacos_plugins.emva_calibration.moments import Frame


@dataclass(frozen=True)
class SpatialVariance:
    """Spatial variance of one channel of a stack [DN^2], its parts, and its standard error.

    ``gradual_dn2`` is what a mean over 41 x 41 pixels retains: uneven light, or shading of the lens.
    """

    frames: int
    mean_dn: float
    total_dn2: float
    row_dn2: float
    column_dn2: float
    pixel_dn2: float
    gradual_dn2: float
    error_dn2: float


def spatial_variance(frames: Iterable[Frame]) -> SpatialVariance:
    """Spatial variance of a stack of at least two frames, temporal noise subtracted."""
    sums: list[NDArray[np.float64]] = []
    squares: list[NDArray[np.float64]] = []
    count = 0
    for frame in frames:
        exact = [plane.astype(np.float64) for plane in frame]
        count += 1
        if not sums:
            sums, squares = [plane.copy() for plane in exact], [plane**2 for plane in exact]
            continue
        for total, square, plane in zip(sums, squares, exact, strict=True):
            total += plane
            square += plane**2
    return _averaged([_of_plane(*both, count) for both in zip(sums, squares, strict=True)], count)


def _of_plane(total: NDArray[np.float64], square: NDArray[np.float64], count: int) -> list[float]:
    mean = total / count
    temporal = float(((square - total * mean) / (count - 1)).mean()) / count
    height, width = mean.shape
    of_rows, of_columns = float(mean.mean(axis=1).var(ddof=1)), float(mean.mean(axis=0).var(ddof=1))
    measured = float(mean.var(ddof=1))
    of_pixels = measured - of_rows - of_columns
    gradual = float(ndimage.uniform_filter(mean, 41, mode="nearest").var())
    error = np.sqrt(2 / mean.size) * measured
    # A mean over a row holds 1/width of what pixels scatter, which is no matter of rows.
    pixel = of_pixels / ((1 - 1 / width) * (1 - 1 / height)) - temporal
    row, column = of_rows - (pixel + temporal) / width, of_columns - (pixel + temporal) / height
    return [float(mean.mean()), measured - temporal, row, column, pixel, gradual, float(error)]


def _averaged(planes: Sequence[Sequence[float]], count: int) -> SpatialVariance:
    mean, total, row, column, pixel, gradual, _ = (float(value) for value in np.mean(planes, axis=0))
    error = float(np.sqrt(np.sum([plane[-1] ** 2 for plane in planes])) / len(planes))
    return SpatialVariance(count, mean, total, row, column, pixel, gradual, error)
