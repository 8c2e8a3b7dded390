"""Mean level against expected level: exposure, tone, offsets, saturation."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tacos_gap.statistics.block import Sample, StatisticBlock
from tacos_gap.statistics.grid import levels

OFFSET_DN = 0.06
RELATIVE = 0.004
"""Equivalence margin of mean levels around the expectation: an absolute and a relative part."""


def level_statistics(sample: Sample) -> Iterator[StatisticBlock]:
    """Mean of real less expected in bins of the expected level, per channel [DN]."""
    for channel, name in enumerate(sample.channels):
        bins = levels(sample.capture, channel)
        if not bins.at:
            continue
        signal = bins.mean(np.abs(sample.signal[..., channel]))
        yield StatisticBlock(
            "dark_level" if sample.capture.kind == "dark" else "level",
            "readout" if sample.capture.kind == "dark" else "exposure",
            bins.mean(sample.residual[..., channel]),
            [{**at, "channel": name} for at in bins.at],
            np.hypot(OFFSET_DN, RELATIVE * signal),
        )
    if sample.repeats or len(sample.frames) > 1:
        overall = sample.frames.mean(axis=(1, 2, 3))
        scale = max(float(sample.signal.mean()), 1.0)
        yield StatisticBlock("frame_to_frame", "exposure", np.array([np.std(overall) / scale]), [{}], 0.003)
