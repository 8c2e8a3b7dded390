"""How level and noise vary over the image."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tacos_gap.statistics.block import ROUNDING_DN2, Sample, StatisticBlock
from tacos_gap.statistics.grid import TILE_COLUMNS, TILE_ROWS, expected_in, rings, tiles

RELATIVE = 0.004
OFFSET_DN = 0.06


def field_statistics(sample: Sample) -> Iterator[StatisticBlock]:
    """Level of tiles over their expectation, and variance over mean in rings, both less their averages."""
    capture = sample.capture
    grid = tiles(capture)
    if len(grid.at) > 3:
        dark = capture.kind == "dark"
        for channel, name in enumerate(sample.channels):
            signal = expected_in(grid, capture, channel)
            scale = np.ones_like(signal) if dark else np.maximum(signal, 2.0)
            shape = grid.mean(sample.residual[..., channel]) / scale
            margin = OFFSET_DN if dark else np.hypot(RELATIVE * scale, OFFSET_DN)
            yield StatisticBlock(
                "dark_field" if dark else "relative_illumination",
                "pixel" if dark else "optics",
                shape - np.average(shape, weights=grid.count),
                [{**at, "channel": name} for at in grid.at],
                np.hypot(margin, _luck_of_lines(sample, channel)) / scale,
            )
    if sample.repeats:
        circles = rings(capture)
        if len(circles.at) > 1:
            rounding = np.float32(ROUNDING_DN2 * len(sample.channels))  # twice below, once in the files
            ratio = (np.einsum("hwc->hw", sample.variance) + rounding) / _expected_variance(sample)
            value = np.log(circles.mean(ratio))
            yield StatisticBlock("noise_over_field", "isp", value - value.mean(), circles.at, 0.02)


def _luck_of_lines(sample: Sample, channel: int) -> float:
    """What lines with offsets of their own put into a tile by chance: where they lie says nothing [DN].

    Their variance is the covariance of halves of the frames, of differences between neighbouring lines.
    """
    if not sample.repeats:
        return 0.0
    first, second = (
        sample.frames[half::2, ..., channel].mean(axis=0) - sample.reference[..., channel] for half in (0, 1)
    )
    luck = 0.0
    for axis, tiles_along in ((0, TILE_COLUMNS), (1, TILE_ROWS)):
        one, two = (np.diff(np.where(sample.valid, half, 0).mean(axis=axis)) for half in (first, second))
        luck += max(float(np.mean(one * two)) / 2, 0.0) * tiles_along / (one.size + 1)
    return float(np.sqrt(luck))


def _expected_variance(sample: Sample) -> np.ndarray:
    """(H, W) noise for the level that was *measured*: what dims light leaves the ratio at 1."""
    black = np.float32(sample.capture.context.black_level_dn)
    level = np.maximum(sample.mean - black, 0)
    rounding = np.float32(2 * ROUNDING_DN2 * level.shape[-1])
    return np.asarray(np.einsum("hwc->hw", sample.capture.noise.variance_dn2(level)) + rounding)
