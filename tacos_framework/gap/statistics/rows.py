"""Rows and columns: noise they share, and waves over rows."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from tacos_framework.gap.statistics.block import Block, Sample

WAVES = 24
"""Periods of a wave over the rows that are looked at: the height over 1, 2, ..."""


def row_statistics(sample: Sample) -> Iterator[Block]:
    """Variance of row and column means over that of independent pixels; waves over the rows."""
    if len(sample.frames) > 1:
        noise = sample.temporal if sample.repeats else sample.frames - sample.expected
        fine = noise - noise.mean(axis=(1, 2), keepdims=True)
    else:
        fine = sample.frames - sample.expected
        fine = fine - fine.mean(axis=(1, 2), keepdims=True)
    even = sample.repeats or sample.capture.kind in ("dark", "flat")
    if even:
        for axis, name in ((2, "row_noise"), (1, "column_noise")):
            yield _shared(fine, axis, name)
    if sample.capture.kind != "dark" and (even or len(sample.frames) > 1):
        yield _waves(sample, fine)


def _shared(fine: NDArray[np.float32], axis: int, name: str) -> Block:
    """Variance of neighbouring line means' differences, over what independent pixels would give."""
    lines = fine.mean(axis=axis)
    steps = np.diff(lines, axis=1) / np.sqrt(2)
    independent = max(float(np.mean(fine**2)), 0.02) / fine.shape[axis]
    return Block(
        name, "readout", np.array([np.log(float(np.mean(steps**2)) / independent + 0.05)]), [{}], 0.05
    )


def _waves(sample: Sample, fine: NDArray[np.float32]) -> Block:
    """Amplitude of waves over the rows of each frame, relative to the signal, by its rms over frames."""
    profile = (fine.mean(axis=-1) * sample.valid).sum(axis=2)
    weight = np.maximum((sample.signal.mean(axis=-1) * sample.valid).sum(axis=1), 1.0)
    profile = profile / weight[None, :]
    spectrum = np.abs(np.fft.rfft(profile - profile.mean(axis=1, keepdims=True), axis=1))
    amplitude = 2 * np.sqrt(np.mean(spectrum**2, axis=0)) / profile.shape[1]
    count = min(WAVES, len(amplitude) - 1)
    at = [{"period_rows": round(profile.shape[1] / k, 1)} for k in range(1, count + 1)]
    return Block("row_waves", "exposure", amplitude[1 : count + 1], at, 0.002)
