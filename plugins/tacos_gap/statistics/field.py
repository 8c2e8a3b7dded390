"""Level and noise over the image."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from tacos_gap.statistics.block import Sample, StatisticBlock
from tacos_gap.statistics.grid import TILE_COLUMNS, TILE_ROWS, expected_in, rings, tile_means, tiles
from tacos_gap.statistics.line_means import line_means
from tacos_gap.statistics.masked import only_in
from tacos_plugins.noise_calibration.photon_transfer import ROUNDING_DN2

RELATIVE = 0.004
OFFSET_DN = 0.06


def field_statistics(sample: Sample) -> Iterator[StatisticBlock]:
    """Level of tiles over their expectation, and variance over mean in rings, both less their averages."""
    capture = sample.capture
    grid = tiles(capture)
    if len(grid.at) > 3 and not (capture.own_edges or capture.own_light):
        dark = capture.kind == "dark"
        levels, luck = tile_means(capture, sample.residual), _luck(sample)
        for channel, name in enumerate(sample.channels):
            signal = expected_in(grid, capture, channel)
            scale = np.ones_like(signal) if dark else np.maximum(signal, 2.0)
            shape = levels[:, channel] / scale
            seen = np.clip(scale + levels[:, channel], 0.0, scale)  # full pixels show no more
            relative = np.hypot(RELATIVE, capture.target_within)
            margin = OFFSET_DN if dark else np.hypot(relative * seen, OFFSET_DN)
            yield StatisticBlock(
                "dark_field" if dark else "relative_illumination",
                "pixel" if dark else "optics",
                shape - np.average(shape, weights=grid.count),
                [{**at, "channel": name} for at in grid.at],
                np.hypot(margin, luck[channel]) / scale,
            )
    if sample.repeats:
        circles = rings(capture)
        if len(circles.at) > 1:
            rounding = np.float32(ROUNDING_DN2 * len(sample.channels))  # twice below, once in the files
            ratio = (
                sample.variance @ np.ones(len(sample.channels), np.float32) + rounding
            ) / _expected_variance(sample)
            value = np.log(circles.in_rows(sample.bands).mean(ratio))
            yield StatisticBlock("noise_over_field", "isp", value - value.mean(), circles.at, 0.02)


def _luck(sample: Sample) -> NDArray[np.float64]:
    """(C,) what offsets of pixels and lines of their own put into a tile by chance [DN].

    Where they lie says nothing, as another specimen of the sensor has them elsewhere. Their variance is the
    covariance of halves of the frames, of differences between neighbours.
    """
    variance = np.zeros(len(sample.channels))
    if not sample.repeats:
        return variance
    halves = [only_in(sample.valid, half) for half in sample.halves]
    for axis, tiles_along in ((0, TILE_COLUMNS), (1, TILE_ROWS)):
        one, two = (np.diff(line_means(half, axis), axis=0) for half in halves)
        variance += np.maximum((one * two).mean(axis=0) / 2, 0.0) * tiles_along / (len(one) + 1)
    one, two = (np.diff(np.diff(half, axis=0), axis=1) for half in halves)  # lines leave nothing
    pixels = np.einsum("hwc,hwc->c", one, two) / (4 * np.count_nonzero(sample.valid))
    variance += np.maximum(pixels, 0.0) * TILE_COLUMNS * TILE_ROWS / np.count_nonzero(sample.valid)
    return np.sqrt(variance)


def _expected_variance(sample: Sample) -> NDArray[np.float32]:
    """(B R, W) noise for the level that was *measured*: what dims light leaves the ratio at 1."""
    black = np.float32(sample.capture.context.black_level_dn)
    noise, rows = sample.capture.noise, sample.bands.ravel()
    level = np.maximum(sample.mean[rows] - black, 0)
    channels = level.shape[-1]
    photon = np.broadcast_to(np.asarray(noise.photon_dn, np.float32), channels)
    thermal = np.broadcast_to(np.asarray(noise.thermal_dn2, np.float32), channels).sum()
    return np.asarray(level @ photon + thermal + np.float32(2 * ROUNDING_DN2 * channels))
