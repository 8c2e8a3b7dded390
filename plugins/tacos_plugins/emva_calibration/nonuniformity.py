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
    planes: list[_Plane] = []
    count = 0
    for frame in frames:
        planes = planes or [_Plane(np.zeros(plane.shape), np.zeros(plane.shape)) for plane in frame]
        count += 1
        for of_plane, plane in zip(planes, frame, strict=True):
            of_plane.add(plane.astype(np.float64))
    return _averaged([_of_plane(plane, count) for plane in planes], count)


class _Plane:
    """Sums of a plane over frames; their means apart, since light that drifts is no noise of pixels."""

    def __init__(self, total: NDArray[np.float64], square: NDArray[np.float64]):
        self.total, self.square = total, square
        self.level = 0.0
        self.rows: list[NDArray[np.float64]] = []

    def add(self, plane: NDArray[np.float64]) -> None:
        level = float(plane.mean())
        plane -= level
        self.level += level
        self.total += plane
        self.square += plane**2
        self.rows.append(plane.mean(axis=1))


def _of_plane(plane: _Plane, count: int) -> list[float]:
    mean = plane.total / count
    temporal = float(((plane.square - plane.total * mean) / (count - 1)).mean()) / count
    bands = float(np.var(plane.rows, axis=0, ddof=1).mean()) / count
    height, width = mean.shape
    of_rows, of_columns = float(mean.mean(axis=1).var(ddof=1)), float(mean.mean(axis=0).var(ddof=1))
    measured = float(mean.var(ddof=1))
    of_pixels = measured - of_rows - of_columns
    gradual = float(ndimage.uniform_filter(mean, 41, mode="nearest").var())
    # Bands of a lamp average out by chance alone: what is left of them may be as large as its expectation.
    error = np.hypot(np.sqrt(2 / mean.size) * measured, max(bands - temporal / width, 0.0))
    # A mean over a row holds 1/width of what pixels scatter, which is no matter of rows.
    pixel = of_pixels / ((1 - 1 / width) * (1 - 1 / height)) - temporal
    row, column = of_rows - (pixel + temporal) / width, of_columns - (pixel + temporal) / height
    return [plane.level / count, measured - temporal, row, column, pixel, gradual, float(error)]


def _averaged(planes: Sequence[Sequence[float]], count: int) -> SpatialVariance:
    mean, total, row, column, pixel, gradual, _ = (float(value) for value in np.mean(planes, axis=0))
    error = float(np.sqrt(np.sum([plane[-1] ** 2 for plane in planes])) / len(planes))
    return SpatialVariance(count, mean, total, row, column, pixel, gradual, error)
