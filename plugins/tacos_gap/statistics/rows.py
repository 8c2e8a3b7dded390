"""Rows and columns: noise they share, and waves over rows."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from tacos_gap.statistics.block import ROUNDING_DN2, Sample, StatisticBlock

WAVES = 24
"""Periods of a wave over the rows that are looked at: the height over 1, 2, ..."""

_LEAST_RATIO = 0.2
"""Added to the ratio, which falls towards 0 where noise is too small to pass the rounding."""


def row_statistics(sample: Sample) -> Iterator[StatisticBlock]:
    """Variance of row and column means over that of independent pixels; waves over the rows."""
    noise = sample.temporal if sample.repeats else sample.frames - sample.expected
    row_means = _row_means(noise)
    even = sample.repeats or sample.capture.kind in ("dark", "flat")
    if even:
        level = row_means.mean(axis=1)
        variance = max(float(np.vdot(noise, noise)) / noise.size - float(np.mean(level**2)), ROUNDING_DN2)
        yield _shared(row_means, variance / noise.shape[2], "row_noise")
        yield _shared(_column_means(noise), variance / noise.shape[1], "column_noise")
    if sample.capture.kind != "dark" and (even or len(sample.frames) > 1):
        yield _waves(sample, noise, row_means)


def _row_means(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """(N, H, C) means along the rows of (N, H, W, C); many times faster than numpy's over a middle axis."""
    import cv2

    means = [cv2.reduce(frame, 1, cv2.REDUCE_AVG) for frame in image]
    return np.stack(means).reshape(image.shape[0], image.shape[1], image.shape[3])


def _column_means(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """(N, W, C) means along the columns of (N, H, W, C)."""
    import cv2

    means = [cv2.reduce(frame, 0, cv2.REDUCE_AVG) for frame in image]
    return np.stack(means).reshape(image.shape[0], image.shape[2], image.shape[3])


def _shared(lines: NDArray[np.float32], independent: float, name: str) -> StatisticBlock:
    """Log variance of neighbouring lines' differences, over what independent pixels would give."""
    steps = np.diff(lines, axis=1) / np.sqrt(2)
    ratio = float(np.mean(steps**2)) / independent
    return StatisticBlock(name, "readout", np.array([np.log(ratio + _LEAST_RATIO)]), [{}], 0.05)


def _waves(sample: Sample, noise: NDArray[np.float32], row_means: NDArray[np.float32]) -> StatisticBlock:
    """Amplitude of waves over the rows of each frame, relative to the signal, by its rms over frames."""
    level = row_means.mean(axis=1, keepdims=True)
    if sample.valid.all():
        profile = (row_means - level).mean(axis=-1) * noise.shape[2]
    else:
        profile = ((noise - level[:, :, None]) * sample.valid[None, :, :, None]).mean(axis=-1).sum(axis=2)
    weight = np.maximum((sample.signal.mean(axis=-1) * sample.valid).sum(axis=1), 1.0)
    profile = profile / weight[None, :]
    spectrum = np.abs(np.fft.rfft(profile - profile.mean(axis=1, keepdims=True), axis=1))
    amplitude = 2 * np.sqrt(np.mean(spectrum**2, axis=0)) / profile.shape[1]
    count = min(WAVES, len(amplitude) - 1)
    at = [{"period_rows": round(profile.shape[1] / k, 1)} for k in range(1, count + 1)]
    return StatisticBlock("row_waves", "exposure", amplitude[1 : count + 1], at, 0.002)
