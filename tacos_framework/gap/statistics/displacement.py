"""Where things appear against where they are expected, per channel."""

from __future__ import annotations

from collections.abc import Iterator
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from tacos_framework.gap.captures import Capture
from tacos_framework.gap.statistics.block import Block, Sample
from tacos_framework.gap.statistics.grid import tiles

AMPLITUDE_PX = 0.03
"""Displacements this small are nobody's concern [px]."""

_TEXTURED = 0.02
"""Gradient that makes a pixel count, over the range of the image per pixel."""


def displacement_statistics(sample: Sample) -> Iterator[Block]:
    """Median displacement in tiles with texture, and that of red and blue against green [px]."""
    capture = sample.capture
    if not capture.is_structured:
        return
    weights = _texture(capture)
    grid = tiles(capture)
    counts = np.array([weights[grid.index == k].sum() for k in range(len(grid.at))])
    chosen = np.flatnonzero(counts > 40)
    if not len(chosen):
        return
    colour = len(sample.channels) == 3
    green = _flow(sample, 1 if colour else 0)
    at = [grid.at[k] for k in chosen.tolist()]
    for axis, name in ((0, "x"), (1, "y")):
        values = _medians(green[..., axis], grid.index, weights, chosen)
        yield Block("displacement", "optics", values, [{**a, "axis": name} for a in at], AMPLITUDE_PX)
    if colour:
        for channel, name in ((0, "R-G"), (2, "B-G")):
            apart = _flow(sample, channel) - green
            for axis, direction in ((0, "x"), (1, "y")):
                values = _medians(apart[..., axis], grid.index, weights, chosen)
                places = [{**a, "axis": direction, "channels": name} for a in at]
                yield Block("colour_displacement", "optics", values, places, AMPLITUDE_PX)


_TEXTURES: WeakKeyDictionary[Capture, NDArray[np.bool_]] = WeakKeyDictionary()


def _texture(capture: Capture) -> NDArray[np.bool_]:
    if capture not in _TEXTURES:
        assert capture.expected_dn is not None
        level = capture.expected_dn[0].mean(axis=-1)
        gy, gx = np.gradient(level)
        _TEXTURES[capture] = (np.hypot(gx, gy) > _TEXTURED * max(np.ptp(level), 1)) & capture.valid
    return _TEXTURES[capture]


def _flow(sample: Sample, channel: int) -> NDArray[np.float32]:
    """Dense flow from the expectation to the frames (Kroeger et al. 2016, DIS), (H, W, 2) [px]."""
    import cv2

    expected, seen = sample.expected[0][..., channel], sample.frames[0][..., channel]
    if len(sample.expected) == 1:
        seen = sample.mean[..., channel]
    low, high = np.percentile(expected, (0.5, 99.5))
    gain = 255 / max(high - low, 1.0)
    own_low, own_high = np.percentile(seen, (0.5, 99.5))
    own_gain = 255 / max(own_high - own_low, 1.0)
    first = np.clip((expected - low) * gain, 0, 255).astype(np.uint8)
    second = np.clip((seen - own_low) * own_gain, 0, 255).astype(np.uint8)
    search = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_FAST)
    search.setFinestScale(1)
    return np.asarray(search.calc(first, second, np.zeros((*first.shape, 2), np.float32)))


def _medians(
    flow: NDArray[np.float32], index: NDArray[np.int64], weights: NDArray[np.bool_], chosen: NDArray[np.int64]
) -> NDArray[np.float64]:
    used, where = flow[weights], index[weights]
    return np.array([float(np.median(used[where == k])) for k in chosen])
