"""How level and noise vary over the image."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tacos_gap.statistics.block import ROUNDING_DN2, Sample, StatisticBlock
from tacos_gap.statistics.grid import rings, tiles

RELATIVE = 0.004
OFFSET_DN = 0.06


def field_statistics(sample: Sample) -> Iterator[StatisticBlock]:
    """Level of tiles over their expectation, and variance over mean in rings, both less their averages."""
    capture = sample.capture
    grid = tiles(capture)
    if len(grid.at) > 3:
        dark = capture.kind == "dark"
        for channel, name in enumerate(sample.channels):
            signal = grid.mean(sample.signal[..., channel])
            scale = np.ones_like(signal) if dark else np.maximum(signal, 2.0)
            shape = grid.mean(sample.residual[..., channel]) / scale
            yield StatisticBlock(
                "dark_field" if dark else "relative_illumination",
                "pixel" if dark else "optics",
                shape - np.average(shape, weights=grid.count),
                [{**at, "channel": name} for at in grid.at],
                OFFSET_DN if dark else np.hypot(RELATIVE, OFFSET_DN / scale),
            )
    if sample.repeats:
        circles = rings(capture)
        if len(circles.at) > 1:
            rounding = np.float32(ROUNDING_DN2 * len(sample.channels))  # twice below, once in the files
            ratio = (np.einsum("hwc->hw", sample.variance) + rounding) / _expected_variance(sample)
            value = np.log(circles.mean(ratio))
            yield StatisticBlock("noise_over_field", "isp", value - value.mean(), circles.at, 0.02)


def _expected_variance(sample: Sample) -> np.ndarray:
    """(H, W) noise for the level that was *measured*: what dims light leaves the ratio at 1."""
    black = np.float32(sample.capture.context.black_level_dn)
    level = np.maximum(sample.mean - black, 0)
    rounding = np.float32(2 * ROUNDING_DN2 * level.shape[-1])
    return np.asarray(np.einsum("hwc->hw", sample.capture.noise.variance_dn2(level)) + rounding)
