"""What repeats from frame to frame and is not in the scene: patterns of the sensor."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from tacos_gap.statistics.block import Sample, StatisticBlock
from tacos_gap.statistics.grid import expected_in, has_even_areas, levels, smooth_areas

_WINDOW_PX = 7
_RELATIVE = 0.0015
_OFFSET_DN = 0.04
_LEAST_OF_A_LINE = 16  # pixels


def fixed_pattern_statistics(sample: Sample) -> Iterator[StatisticBlock]:
    """Covariance of independent halves of the frames after a high-pass: of pixels, of columns, of rows."""
    repeated = sample.repeats and sample.capture.kind in ("dark", "flat", "bracket")
    if repeated and has_even_areas(sample.capture):
        yield from _covariance(sample)


def _covariance(sample: Sample) -> Iterator[StatisticBlock]:
    even = smooth_areas(sample.capture) & sample.valid
    first = _fine(sample.frames[0::2].mean(axis=0) - sample.reference)
    second = _fine(sample.frames[1::2].mean(axis=0) - sample.reference)
    count = [even.sum(axis=axis) for axis in (0, 1)]
    product = np.clip(first * second, -400, 400)
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
        one, two = (half[..., channel] * even for half in (first, second))
        for axis, name in ((0, "column_pattern"), (1, "row_pattern")):
            filled = count[axis] > _LEAST_OF_A_LINE
            a, b = (half.sum(axis=axis)[filled] / count[axis][filled] for half in (one, two))
            if not filled.any():
                continue
            value = np.array([float(np.mean(a * b))])
            amplitude = (0.3 * _OFFSET_DN) ** 2 + (0.2 * _RELATIVE * signal.mean()) ** 2
            luck = np.abs(value) * np.sqrt(2 / np.count_nonzero(filled))
            yield StatisticBlock(name, "pixel", value, [{"channel": label}], np.hypot(amplitude, luck))


def _fine(image: NDArray[np.float32]) -> NDArray[np.float32]:
    import cv2

    blurred = cv2.blur(image, (_WINDOW_PX, _WINDOW_PX)).reshape(image.shape)
    return np.asarray(image - blurred, np.float32)
