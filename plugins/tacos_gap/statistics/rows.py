"""Rows and columns: noise they share, and waves over rows."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from tacos_gap.statistics.block import Sample, StatisticBlock
from tacos_gap.statistics.line_means import line_means_of_frames, over_channels
from tacos_gap.statistics.masked import only_in
from tacos_gap.statistics.steady_light import in_steady_light
from tacos_plugins.effects.row_waves import SHADING_DEGREE, amplitudes
from tacos_plugins.noise_calibration.photon_transfer import ROUNDING_DN2

WAVES = 24
"""Periods of a wave over the rows that are looked at: the height over 1, 2, ..."""

_LEAST_RATIO = 0.2
"""Added to the ratio, which falls towards 0 where noise is too small to pass the rounding."""


def row_statistics(sample: Sample) -> Iterator[StatisticBlock]:
    """Variance of row and column means over that of independent pixels; waves over the rows."""
    even = sample.repeats or sample.capture.kind in ("dark", "flat")
    if even:
        height, width = sample.valid.shape
        row_means = _of_noise(sample, 1)
        variance = max(_of_pixels(sample, row_means), ROUNDING_DN2)
        yield _shared(row_means, variance / width, "row_noise")
        yield _shared(_of_noise(sample, 0), variance / height, "column_noise")
    if sample.capture.kind != "dark" and (even or len(sample.frames) > 1):
        yield _waves(sample)


def _of_noise(sample: Sample, axis: int) -> NDArray[np.float32]:
    """(N, H or W, C) means of the lines of the noise: of frames less their mean, or less the expectation."""
    if not sample.repeats:
        return line_means_of_frames(sample.frames, axis) - line_means_of_frames(sample.expected, axis)
    means = sample.row_means if axis else line_means_of_frames(sample.frames, 0)
    means = in_steady_light(sample.capture, means, sample.light_of_frames)
    return (means - means.mean(axis=0)) * np.float32(np.sqrt(len(means) / (len(means) - 1)))


def _of_pixels(sample: Sample, row_means: NDArray[np.float32]) -> float:
    """Mean square of the noise of a pixel beside that of its row [DN^2]."""
    if sample.repeats:
        return float(np.vdot(sample.temporal, sample.temporal)) / sample.temporal.size
    noise = sample.frames - sample.expected
    return float(np.vdot(noise, noise)) / noise.size - float(np.mean(row_means.mean(axis=1) ** 2))


def _shared(lines: NDArray[np.float32], independent: float, name: str) -> StatisticBlock:
    """Log variance of neighbouring lines' differences, over what independent pixels would give.

    Differences of third order, in which no wave of many lines is left.
    """
    steps = np.diff(lines, n=3, axis=1) / np.sqrt(20)
    ratio = float(np.mean(steps**2)) / independent
    return StatisticBlock(name, "readout", np.array([np.log(ratio + _LEAST_RATIO)]), [{}], 0.05)


def _waves(sample: Sample) -> StatisticBlock:
    """Amplitude of waves over the rows of each frame, relative to the signal, by its rms over frames.

    A lamp has another phase in each frame. Of a wall, what all frames share counts as well as what parts
    them: two frames that met the lamp at the same phase show it as one does. Of other pictures, what they
    share may be the expectation's.
    """
    profiles = _profiles(sample)
    height = profiles.shape[1]
    periods = [height / k for k in range(1, min(WAVES, height // 2) + 1)]
    if sample.capture.kind == "flat":
        shared = profiles.mean(axis=0, keepdims=True)
        parted = np.mean(amplitudes(profiles - shared, periods) ** 2, axis=0)
        squares = amplitudes(shared, periods, SHADING_DEGREE)[0] ** 2 + parted
    elif sample.repeats:
        parted = amplitudes(profiles - profiles.mean(axis=0), periods) ** 2
        squares = np.sum(parted, axis=0) / (len(profiles) - 1)
    else:
        squares = np.mean(amplitudes(profiles, periods) ** 2, axis=0)
    at = [{"period_rows": round(period, 1)} for period in periods]
    return StatisticBlock("row_waves", "exposure", np.sqrt(squares), at, 0.002)


def _profiles(sample: Sample) -> NDArray[np.float64]:
    """(N, H) means of each frame's rows less what is expected, over the signal."""
    frames, expected = (only_in(sample.valid, each) for each in (sample.frames, sample.expected))
    rows = line_means_of_frames(frames, 1) if not sample.valid.all() else sample.row_means
    if sample.repeats:
        rows = in_steady_light(sample.capture, rows, sample.light_of_frames)
    off = (rows - line_means_of_frames(expected, 1)).mean(axis=-1) * sample.valid.shape[1]
    off = off - off.mean(axis=1, keepdims=True) * sample.valid.mean(axis=1) / sample.valid.mean()
    weight = (over_channels(sample.signal) * sample.valid).sum(axis=1)
    return np.asarray(off / np.maximum(weight, 1.0), np.float64)
