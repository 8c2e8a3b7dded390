"""Fixed patterns of the sensor: what repeats from frame to frame and is not in the scene."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from tacos_gap.nuisances.mosaic import of_each_plane
from tacos_gap.statistics.block import Sample, StatisticBlock
from tacos_gap.statistics.grid import expected_in, has_even_areas, levels, smooth_areas
from tacos_gap.statistics.line_means import line_means
from tacos_gap.statistics.masked import only_in

_WINDOW_PX = 7
_WINDOW_OF_A_PLANE = 5  # photosites of one colour
_RELATIVE = 0.0007
_OFFSET_DN = 0.04
"""Equivalence margins of a pattern's rms, over the signal and in the dark. Sensors have a PRNU of .2 % and
more: a margin as wide would hide it, and its neighbours in the same captures would be blamed."""

_LINES_RELATIVE = 0.0003
_LINES_DN = 0.012
"""Those of the rms of columns and rows."""

_LEAST_OF_A_LINE = 16  # pixels


def fixed_pattern_statistics(sample: Sample) -> Iterator[StatisticBlock]:
    """Covariance of independent halves of the frames after a high-pass: of pixels, of columns, of rows."""
    if sample.repeats and sample.capture.shows_patterns and has_even_areas(sample.capture):
        yield from _covariance(sample)


def _covariance(sample: Sample) -> Iterator[StatisticBlock]:
    even = smooth_areas(sample.capture) & sample.valid
    first, second = (_fine(half, sample.capture.context.cfa) for half in sample.halves)
    count = [even.sum(axis=axis) for axis in (0, 1)]
    one, two = (only_in(even, half) for half in (first, second))
    lines = [[line_means(half, axis) * even.shape[axis] for half in (one, two)] for axis in (0, 1)]
    product = np.multiply(first, second, out=first)
    np.clip(product, -400, 400, out=product)
    for channel, label in enumerate(sample.channels):
        bins = levels(sample.capture, channel, even)
        if not bins.at:
            continue
        signal = expected_in(bins, sample.capture, channel)
        yield StatisticBlock(
            "fixed_pattern",
            "pixel",
            bins.mean(product[..., channel]),
            [{**at, "channel": label} for at in bins.at],
            (_RELATIVE * signal) ** 2 + _OFFSET_DN**2,
        )
        for axis, name in ((0, "column_pattern"), (1, "row_pattern")):
            filled = count[axis] > _LEAST_OF_A_LINE
            a, b = (half[filled, channel] / count[axis][filled] for half in lines[axis])
            if not filled.any():
                continue
            value = np.array([float(np.mean(a * b))])
            amplitude = _LINES_DN**2 + (_LINES_RELATIVE * signal.mean()) ** 2
            luck = np.abs(value) * np.sqrt(2 / np.count_nonzero(filled))
            yield StatisticBlock(name, "pixel", value, [{"channel": label}], np.hypot(amplitude, luck))


def _fine(image: NDArray[np.float32], cfa: str | None) -> NDArray[np.float32]:
    """(H, W, C) an image less its local mean, among photosites of one colour where a mosaic has several.

    Levels that are off by a percent would else leave a percent of the mosaic.
    """
    if cfa is None:
        return _less_local_mean(image, _WINDOW_PX)
    return of_each_plane(image, lambda plane: _less_local_mean(plane, _WINDOW_OF_A_PLANE))


def _less_local_mean(image: NDArray[np.float32], window: int) -> NDArray[np.float32]:
    import cv2

    blurred = np.asarray(cv2.blur(image, (window, window)), np.float32).reshape(image.shape)
    return np.subtract(image, blurred, out=blurred)
