"""Rows and columns: noise they share, and waves over rows."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from tacos_gap.statistics.block import Sample, StatisticBlock
from tacos_gap.statistics.line_means import line_means_of_frames, over_channels
from tacos_gap.statistics.masked import only_in
from tacos_gap.statistics.steady_light import in_steady_light
from tacos_plugins.noise_calibration.photon_transfer import ROUNDING_DN2

WAVES = 24
"""Periods of a wave over the rows that are looked at: the height over 1, 2, ..."""

_LEAST_RATIO = 0.2
"""Added to the ratio, which falls towards 0 where noise is too small to pass the rounding."""


def row_statistics(sample: Sample) -> Iterator[StatisticBlock]:
    """Variance of row and column means over that of independent pixels; waves over the rows."""
    even = sample.repeats or sample.capture.kind in ("dark", "flat")
    waves = sample.capture.kind != "dark" and (even or len(sample.frames) > 1)
    if not (even or waves):
        return
    row_means = _of_noise(sample, 1)
    if even:
        height, width = sample.valid.shape
        variance = max(_mean_square(sample) - float(np.mean(row_means.mean(axis=1) ** 2)), ROUNDING_DN2)
        yield _shared(row_means, variance / width, "row_noise")
        yield _shared(_of_noise(sample, 0), variance / height, "column_noise")
    if waves:
        yield _waves(sample, row_means)


def _of_noise(sample: Sample, axis: int, counted: NDArray[np.bool_] | None = None) -> NDArray[np.float32]:
    """(N, H or W, C) means of the lines of the noise: of frames less their mean, or less the expectation.

    Where (H, W) `counted` is given, other pixels are 0.
    """
    if not sample.repeats:
        frames, expected = (
            each if counted is None else only_in(counted, each) for each in (sample.frames, sample.expected)
        )
        return line_means_of_frames(frames, axis) - line_means_of_frames(expected, axis)
    capture, frames = sample.capture, sample.frames
    levels = sample.light_of_frames
    if counted is None:
        means = sample.row_means if axis else line_means_of_frames(frames, 0)
        means = in_steady_light(capture, means, levels)
    else:
        means = line_means_of_frames(only_in(counted, in_steady_light(capture, frames, levels)), axis)
    return (means - means.mean(axis=0)) * np.float32(np.sqrt(len(means) / (len(means) - 1)))


def _mean_square(sample: Sample) -> float:
    """Mean square of the noise of a pixel [DN^2]."""
    noise = sample.temporal if sample.repeats else sample.frames - sample.expected
    return float(np.vdot(noise, noise)) / noise.size


def _shared(lines: NDArray[np.float32], independent: float, name: str) -> StatisticBlock:
    """Log variance of neighbouring lines' differences, over what independent pixels would give."""
    steps = np.diff(lines, axis=1) / np.sqrt(2)
    ratio = float(np.mean(steps**2)) / independent
    return StatisticBlock(name, "readout", np.array([np.log(ratio + _LEAST_RATIO)]), [{}], 0.05)


def _waves(sample: Sample, row_means: NDArray[np.float32]) -> StatisticBlock:
    """Amplitude of waves over the rows of each frame, relative to the signal, by its rms over frames."""
    level = row_means.mean(axis=1, keepdims=True)
    profile = row_means - level
    if not sample.valid.all():
        of_valid = _of_noise(sample, 1, sample.valid)
        profile = of_valid - level * sample.valid.mean(axis=1)[:, None]
    weight = np.maximum((over_channels(sample.signal) * sample.valid).sum(axis=1), 1.0)
    profile = profile.mean(axis=-1) * sample.valid.shape[1] / weight[None, :]
    spectrum = np.abs(np.fft.rfft(profile - profile.mean(axis=1, keepdims=True), axis=1))
    amplitude = 2 * np.sqrt(np.mean(spectrum**2, axis=0)) / profile.shape[1]
    count = min(WAVES, len(amplitude) - 1)
    at = [{"period_rows": round(profile.shape[1] / k, 1)} for k in range(1, count + 1)]
    return StatisticBlock("row_waves", "exposure", amplitude[1 : count + 1], at, 0.002)
