"""Where things appear against where they are expected, per channel.

Dense flow finds large displacements, but jumps as noise and shape have it: a picture moved by a fiftieth of a
pixel by an effect and by a nuisance gave numbers 60 % apart. So flow is where least squares begin, whose end
is a smooth function of the frames.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
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

_STEPS = 3
"""Least squares after flow: the third moves medians of tiles by less than a thousandth of a pixel."""

_DAMPED = 0.01
"""Share of the gradients' sum of squares added to either axis: along an edge nothing is known."""

_LEAST_GAIN = 0.1
"""Contrast of a tile over what is expected at least: without any, nothing says where it went."""

_GRID = 32
"""Places per pixel at which OpenCV's `remap` reads; it rounds others."""


def displacement_statistics(sample: Sample) -> Iterator[StatisticBlock]:
    """Displacement of tiles with texture, and that of red and blue against green [px]."""
    capture = sample.capture
    if not (capture.is_structured and has_texture(capture)):
        return
    spots = _spots(capture)
    colour = len(sample.channels) == 3
    green = _displacements(sample, 1 if colour else 0)
    for values, axis in zip(green, "xy", strict=True):
        at = [{**a, "axis": axis} for a in spots.at]
        yield StatisticBlock("displacement", "optics", values, at, AMPLITUDE_PX)
    if colour:
        for channel, name in ((0, "R-G"), (2, "B-G")):
            apart = _displacements(sample, channel) - green
            for values, axis in zip(apart, "xy", strict=True):
                places = [{**a, "axis": axis, "channels": name} for a in spots.at]
                yield StatisticBlock("colour_displacement", "optics", values, places, AMPLITUDE_PX)


def has_texture(capture: RealCapture) -> bool:
    """Whether a structured capture is large enough and has tiles with texture."""
    return min(capture.valid.shape) >= _LEAST_SIDE_PX and bool(_spots(capture).parts)


@dataclass(frozen=True, eq=False)
class _Spots:
    """Textured pixels, tile by tile, as flat indices.

    Parameters
    ----------
    parts
        The pixels of each tile.
    at
        What each tile is.
    tile
        (H, W) the tile that moves each pixel.
    """

    parts: Sequence[NDArray[np.int64]]
    at: Sequence[Mapping[str, Any]]
    tile: NDArray[np.int64]

    def medians(self, field: NDArray[np.float32]) -> NDArray[np.float64]:
        """(2, T) medians of both components of an (H, W, 2) field in each tile."""
        flat = np.ascontiguousarray(field.reshape(-1, 2).T)
        middles = [np.partition(flat[:, part], len(part) // 2)[:, len(part) // 2] for part in self.parts]
        return np.array(middles, np.float64).reshape(-1, 2).T

    @cached_property
    def _pixels(self) -> NDArray[np.int64]:
        return np.concatenate(self.parts)

    @cached_property
    def _starts(self) -> NDArray[np.int64]:
        return np.cumsum([0, *(len(part) for part in self.parts[:-1])])

    def sums(self, images: Sequence[NDArray[np.float32]]) -> NDArray[np.float64]:
        """(I, I, T) centred sums of products of (H, W) images in each tile."""
        pixels = [image.ravel()[self._pixels].astype(np.float64) for image in images]
        centred = [p - np.repeat(self._means(p), self._counts) for p in pixels]
        found = np.empty((len(images), len(images), len(self.parts)))
        for i, one in enumerate(centred):
            for j, other in enumerate(centred[: i + 1]):
                found[i, j] = found[j, i] = np.add.reduceat(one * other, self._starts)
        return found

    @cached_property
    def _counts(self) -> NDArray[np.int64]:
        return np.array([len(part) for part in self.parts])

    def _means(self, pixels: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(np.add.reduceat(pixels, self._starts) / self._counts)


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
        number = np.zeros(len(grid.at) + 1, np.int64)  # the last is of pixels in no tile
        number[kept] = np.arange(len(kept))
        _SPOTS[capture] = _Spots([parts[k] for k in kept], [grid.at[k] for k in kept], number[grid.index])
    return _SPOTS[capture]


def _displacements(sample: Sample, channel: int) -> NDArray[np.float64]:
    """(2, T) displacements in x and y of the frames' tiles against the expectation [px].

    Those for which the expectation, moved by them, differs least from the frames but for a gain and an offset
    of each tile (Lucas & Kanade 1981). Both are smoothed by binomials, which even out a mosaic.
    """
    import cv2

    spots = _spots(sample.capture)
    full = np.float32(sample.capture.context.white_level_dn)
    frame = _smoothed(_compared(sample)[..., channel])
    expected = _smoothed(np.minimum(sample.expected[0][..., channel], full))
    slope_y, slope_x = (np.asarray(slope, np.float32) for slope in np.gradient(expected))
    x, y = np.meshgrid(*(np.arange(side, dtype=np.float32) for side in frame.shape[::-1]))
    moved = spots.medians(_flow(sample, channel))
    for _ in range(_STEPS):
        moved = np.asarray(np.round(moved * _GRID) / _GRID)
        dx, dy = moved.astype(np.float32)[:, spots.tile]
        read = [
            np.asarray(
                cv2.remap(image, x - dx, y - dy, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE), np.float32
            )
            for image in (expected, slope_x, slope_y)
        ]
        moved = np.asarray(moved + _step(spots.sums([frame, *read])))
    return moved


def _step(products: NDArray[np.float64]) -> NDArray[np.float64]:
    """(2, T) least squares of what is left to move [px].

    Parameters
    ----------
    products
        (4, 4, T) centred sums of products of frame, expectation and its slopes in x and y.
    """
    of_frame, of_expected = products[0], products[1]
    power = np.maximum(of_expected[1], 1e-9)
    gain = np.maximum(of_frame[1] / power, _LEAST_GAIN)
    xx, xy, yy = (
        products[i, j] - of_expected[i] * of_expected[j] / power for i, j in ((2, 2), (2, 3), (3, 3))
    )
    tx, ty = (of_frame[i] - of_frame[1] * of_expected[i] / power for i in (2, 3))
    damping = _DAMPED * (xx + yy) + 1e-9
    xx, yy = xx + damping, yy + damping
    left = np.stack([yy * tx - xy * ty, xx * ty - xy * tx]) / (xx * yy - xy**2)
    return np.asarray(np.clip(-left / gain, -1.0, 1.0))


def _smoothed(image: NDArray[np.float32]) -> NDArray[np.float32]:
    import cv2

    return np.asarray(cv2.GaussianBlur(np.ascontiguousarray(image), (5, 5), 0), np.float32)  # 1 4 6 4 1


def _compared(sample: Sample) -> NDArray[np.float32]:
    """(H, W, C) frames that are compared with the first expectation [DN]."""
    return sample.mean if len(sample.expected) == 1 else sample.frames[0]


def _flow(sample: Sample, channel: int) -> NDArray[np.float32]:
    """Dense flow from the expectation to the frames (Kroeger et al. 2016, DIS), (H, W, 2) [px]."""
    import cv2

    first = _stretched_expectation(sample, channel)
    second = _stretched(_compared(sample)[..., channel])
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
