"""Mean level against expected level: exposure, tone, offsets, saturation."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tacos_gap.statistics.block import Sample, StatisticBlock, mean_signal
from tacos_gap.statistics.grid import expected_in, levels

OFFSET_DN = 0.06
RELATIVE = 0.004
"""Equivalence margin of mean levels around the expectation: an absolute part, and one of the level seen."""

FEWEST_IN_A_ROW = 3
"""Frames of a sequence that tell a drift from two frames that differ."""

OVER_TIME = 0.003
"""Equivalence margin of a frame's level against the mean of its sequence, relative."""

FRAME_TO_FRAME = 0.003
"""The same of the standard deviation of frames of one setting, beside what the level is uncertain by."""


def level_statistics(sample: Sample) -> Iterator[StatisticBlock]:
    """Mean of real less expected in bins of the expected level, per channel [DN]."""
    for channel, name in enumerate(sample.channels if not sample.capture.own_edges else ()):
        bins = levels(sample.capture, channel)
        if not bins.at:
            continue
        signal = expected_in(bins, sample.capture, channel)
        off = bins.mean(sample.residual[..., channel])
        relative = np.hypot(RELATIVE, sample.capture.target_within)
        yield StatisticBlock(
            "dark_level" if sample.capture.kind == "dark" else "level",
            "readout" if sample.capture.kind == "dark" else "exposure",
            off,
            [{**at, "channel": name} for at in bins.at],
            np.hypot(OFFSET_DN, relative * np.clip(signal + off, 0.0, signal)),  # full pixels show no more
        )
    if sample.capture.kind == "sequence" and len(sample.frames) >= FEWEST_IN_A_ROW:
        yield from _over_time(sample)
    if sample.repeats or len(sample.frames) > 1:
        overall = sample.row_means.mean(axis=(1, 2), dtype=np.float64)
        scale = max(float(mean_signal(sample.capture).mean()), 1.0)
        margin = float(np.hypot(FRAME_TO_FRAME, sample.capture.level_uncertainty))
        yield StatisticBlock("frame_to_frame", "exposure", np.array([np.std(overall) / scale]), [{}], margin)


def _over_time(sample: Sample) -> Iterator[StatisticBlock]:
    """Level of each frame of a sequence over its expectation, less the mean of all of them [1]."""
    valid = sample.capture.valid
    signal = np.abs(mean_signal(sample.capture))
    for channel, name in enumerate(sample.channels):
        residual = sample.frames[..., channel] - sample.expected[..., channel]
        scale = max(float(signal[channel]), 1.0)
        off = residual[:, valid].mean(axis=1) / scale
        at = [{"frame": i, "channel": name} for i in range(len(off))]
        yield StatisticBlock("level_over_time", "exposure", off - off.mean(), at, OVER_TIME)
