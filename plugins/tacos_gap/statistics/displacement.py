"""Where things appear against where they are expected, per channel."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from tacos_gap.captures import RealCapture
from tacos_gap.statistics.block import Sample, StatisticBlock
from tacos_gap.statistics.grid import tiles

AMPLITUDE_PX = 0.03
"""Equivalence margin: smaller displacements are negligible [px]."""

_LEAST_PIXELS = 40
_LEAST_SIDE_PX = 32
"""Side of an image below which no flow is looked for."""

_TEXTURED = 0.02
"""Gradient that makes a pixel count, over the range of the image per pixel."""


def displacement_statistics(sample: Sample) -> Iterator[StatisticBlock]:
    """Median displacement in tiles with texture, and that of red and blue against green [px]."""
    capture = sample.capture
    if not (capture.is_structured and has_texture(capture)):
        return
    spots = _spots(capture)
    colour = len(sample.channels) == 3
    if capture.own_edges and not colour:
        return
    green = _flow(sample, 1 if colour else 0)
    at = spots.at
    if not capture.own_edges:
        for values, axis in zip(spots.medians(green), "xy", strict=True):
            yield StatisticBlock(
                "displacement", "optics", values, [{**a, "axis": axis} for a in at], AMPLITUDE_PX
            )
    if colour:
        for channel, name in ((0, "R-G"), (2, "B-G")):
            apart = _flow(sample, channel) - green
            for values, axis in zip(spots.medians(apart), "xy", strict=True):
                places = [{**a, "axis": axis, "channels": name} for a in at]
                yield StatisticBlock("colour_displacement", "optics", values, places, AMPLITUDE_PX)


def has_texture(capture: RealCapture) -> bool:
    """Whether a structured capture is large enough and has tiles with texture."""
    return min(capture.valid.shape) >= _LEAST_SIDE_PX and bool(_spots(capture).parts)


@dataclass(frozen=True, eq=False)
class _Spots:
    """Textured pixels, tile by tile, as flat indices."""

    parts: Sequence[NDArray[np.int64]]
    at: Sequence[Mapping[str, Any]]

    def medians(self, field: NDArray[np.float32]) -> NDArray[np.float64]:
        """(2, T) medians of both components of an (H, W, 2) field in each tile."""
        flat = np.ascontiguousarray(field.reshape(-1, 2).T)
        middles = [np.partition(flat[:, part], len(part) // 2)[:, len(part) // 2] for part in self.parts]
        return np.array(middles, np.float64).reshape(-1, 2).T


_SPOTS: WeakKeyDictionary[RealCapture, _Spots] = WeakKeyDictionary()


def _spots(capture: RealCapture) -> _Spots:
    if capture not in _SPOTS:
        assert capture.expected_dn is not None
        level = capture.expected_dn[0].mean(axis=-1)
        gy, gx = np.gradient(level)
        textured = (np.hypot(gx, gy) > _TEXTURED * max(np.ptp(level), 1)) & capture.valid
        grid = tiles(capture)
        where = np.flatnonzero(textured)
        tile = grid.index.ravel()[where]
        parts = [where[tile == k] for k in range(len(grid.at))]
        kept = [k for k, part in enumerate(parts) if len(part) > _LEAST_PIXELS]
        _SPOTS[capture] = _Spots([parts[k] for k in kept], [grid.at[k] for k in kept])
    return _SPOTS[capture]


def _flow(sample: Sample, channel: int) -> NDArray[np.float32]:
    """Dense flow from the expectation to the frames (Kroeger et al. 2016, DIS), (H, W, 2) [px]."""
    import cv2

    one = len(sample.expected) == 1
    first = _stretched_expectation(sample, channel)
    second = _stretched((sample.mean if one else sample.frames[0])[..., channel])
    search = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_FAST)
    search.setFinestScale(1)
    search.setVariationalRefinementIterations(0)  # twice the time; medians over tiles hardly change
    return np.asarray(search.calc(first, second, np.zeros((*first.shape, 2), np.float32)))


_STRETCHED: WeakKeyDictionary[RealCapture, dict[int, tuple[NDArray[np.float32], NDArray[np.uint8]]]] = (
    WeakKeyDictionary()
)


def _stretched_expectation(sample: Sample, channel: int) -> NDArray[np.uint8]:
    """What frames are compared with, worked out once as long as it is the same array."""
    known = _STRETCHED.setdefault(sample.capture, {})
    if channel not in known or known[channel][0] is not sample.expected:
        known[channel] = sample.expected, _stretched(sample.expected[0][..., channel])
    return known[channel][1]


def _stretched(image: NDArray[np.float32]) -> NDArray[np.uint8]:
    """An image stretched over 8 bits, but for its extremes; a sixteenth of the pixels tells its range."""
    low, high = np.percentile(image[2::4, 2::4], (0.5, 99.5))
    gain = 255 / max(float(high - low), 1.0)
    return np.asarray(np.clip((image - np.float32(low)) * np.float32(gain), 0, 255).astype(np.uint8))
