"""Where things appear against where they are expected, per channel.

Dense flow finds large displacements, but jumps as noise and shape have it: a picture moved by a fiftieth of a
pixel by an effect and by a nuisance gave numbers 60 % apart. So flow is where least squares begin, whose end
is a smooth function of the frames; those of red and blue begin where green was found.
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
from tacos_gap.statistics.flow import ASTRAY_PX, dense_flow, smooth_field
from tacos_gap.statistics.grid import tiles

AMPLITUDE_PX = 0.03
"""Equivalence margin: smaller displacements are negligible [px]."""

_LEAST_PIXELS = 40
_LEAST_SIDE_PX = 32
"""Side of an image below which no flow is looked for."""

_REACH_PX = 4
"""How far from a pixel its smoothed slope looks."""

_TEXTURED = 0.02
"""Gradient that makes a pixel count, over the range of the image per pixel."""

_STEPS = 3
"""Least squares at most; a further one where the last shows that it began far off."""

_NEAR_PX = 0.75
"""A move beyond the whole pixels by less is as good as from the pixels nearest to it."""

_DAMPED = 0.01
"""Share of the slopes' sum of squares added to either axis: along an edge nothing is known."""

_LEAST_GAIN = 0.1
"""Contrast of a tile over what is expected at least: without any, nothing says where it went."""

_SLOPE = np.array([1, -8, 0, 8, -1], np.float32) / 12
"""Central difference of fourth order (Fornberg 1988)."""


def displacement_statistics(sample: Sample) -> Iterator[StatisticBlock]:
    """Displacement of tiles with texture, and that of red and blue against green [px]."""
    capture = sample.capture
    if not (capture.is_structured and has_texture(capture)):
        return
    spots = _spots(capture)
    colour = len(sample.channels) == 3
    if capture.own_edges and not colour:
        return
    channel = 1 if colour else 0
    green = _displacements(sample, channel, _begun(sample, channel))
    if not capture.own_edges:
        for values, axis in zip(green, "xy", strict=True):
            at = [{**a, "axis": axis} for a in spots.at]
            yield StatisticBlock("displacement", "optics", values, at, AMPLITUDE_PX)
    if colour:
        for channel, name in ((0, "R-G"), (2, "B-G")):
            apart = _displacements(sample, channel, green) - green
            for values, axis in zip(apart, "xy", strict=True):
                places = [{**a, "axis": axis, "channels": name} for a in spots.at]
                yield StatisticBlock("colour_displacement", "optics", values, places, AMPLITUDE_PX)


def has_texture(capture: RealCapture) -> bool:
    """Whether a structured capture is large enough and has tiles with texture."""
    return min(capture.valid.shape) >= _LEAST_SIDE_PX and bool(_spots(capture).parts)


@dataclass(frozen=True, eq=False)
class _Spots:
    """Textured pixels, tile by tile.

    Parameters
    ----------
    parts
        The pixels of each tile, as flat indices.
    at
        What each tile is.
    """

    parts: Sequence[NDArray[np.int64]]
    at: Sequence[Mapping[str, Any]]

    @cached_property
    def middles_px(self) -> NDArray[np.float64]:
        """(T, 2) middles of the tiles [px]."""
        boxes = np.array([at["box_px"] for at in self.at], float).reshape(-1, 2, 2)
        return np.asarray(boxes.mean(axis=1))

    def medians(self, field: NDArray[np.float32]) -> NDArray[np.float64]:
        """(2, T) medians of both components of an (H, W, 2) field in each tile."""
        flat = np.ascontiguousarray(field.reshape(-1, 2).T)
        middles = [np.partition(flat[:, part], len(part) // 2)[:, len(part) // 2] for part in self.parts]
        return np.array(middles, np.float64).reshape(-1, 2).T

    def centred(
        self, images: NDArray[np.float32], moved_px: NDArray[np.int64] | None = None
    ) -> NDArray[np.float64]:
        """(I, P) pixels of (I, H, W) images, tiles of which may be moved, less the mean of their tile."""
        flat = images.reshape(len(images), -1)
        if moved_px is None or not moved_px.any():
            values = flat[:, self._pixels].astype(np.float64)
        else:
            height, width = images.shape[1:]
            rows, columns = np.divmod(self._pixels, width)
            columns = np.clip(columns - self.spread(moved_px[0]), 0, width - 1)
            rows = np.clip(rows - self.spread(moved_px[1]), 0, height - 1)
            values = flat[:, rows * width + columns].astype(np.float64)
        values -= self.spread(self.sums(values) / self._counts)
        return values

    def sums(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """(..., T) sums of (..., P) values over tiles."""
        return np.asarray(np.add.reduceat(values, self._starts, axis=-1))

    def spread(self, values: NDArray[Any]) -> NDArray[Any]:
        """(..., P) the value of its tile for each pixel, of (..., T) values."""
        return values[..., self._tile]

    @cached_property
    def _pixels(self) -> NDArray[np.int64]:
        return np.concatenate(self.parts)

    @cached_property
    def _counts(self) -> NDArray[np.int64]:
        return np.array([len(part) for part in self.parts])

    @cached_property
    def _starts(self) -> NDArray[np.int64]:
        return np.cumsum([0, *self._counts[:-1]])

    @cached_property
    def _tile(self) -> NDArray[np.int64]:
        return np.repeat(np.arange(len(self.parts)), self._counts)


_SPOTS: WeakKeyDictionary[RealCapture, _Spots] = WeakKeyDictionary()


def _spots(capture: RealCapture) -> _Spots:
    if capture not in _SPOTS:
        assert capture.expected_dn is not None
        level = capture.expected_dn[0].mean(axis=-1)
        gy, gx = np.gradient(level)
        textured = (np.hypot(gx, gy) > _TEXTURED * max(np.ptp(level), 1)) & _well_inside(capture.valid)
        grid = tiles(capture)
        where = np.flatnonzero(textured)
        tile = grid.index.ravel()[where]
        parts = [where[tile == k] for k in range(len(grid.at))]
        kept = [k for k, part in enumerate(parts) if len(part) > _LEAST_PIXELS]
        _SPOTS[capture] = _Spots([parts[k] for k in kept], [grid.at[k] for k in kept])
    return _SPOTS[capture]


def _well_inside(valid: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(H, W) whether all pixels that a slope is made of are valid; beyond the picture's border they are."""
    import cv2

    around = np.ones((2 * _REACH_PX + 1,) * 2, np.uint8)
    return np.asarray(cv2.erode(valid.astype(np.uint8), around), bool)


def _begun(sample: Sample, channel: int) -> NDArray[np.float64]:
    """(2, T) dense flow of the tiles, or its smooth field where flow went astray and the field fits [px]."""
    spots = _spots(sample.capture)
    flow = spots.medians(dense_flow(sample, _compared(sample), channel))
    field = smooth_field(spots.middles_px, flow)
    if np.abs(flow - field).max(initial=0.0) < ASTRAY_PX:
        return flow
    seen = spots.centred(_smoothed(_compared(sample)[..., channel])[None])[0]
    smooth = _reference(sample, channel).images[:1]
    left = []
    for begun in (flow, field):
        there = spots.centred(smooth, np.rint(begun).astype(np.int64))[0]
        left.append(spots.sums((seen - _gain(spots, seen, there) * there) ** 2))
    return np.where(left[1] < left[0], field, flow)


def _displacements(sample: Sample, channel: int, begun: NDArray[np.float64]) -> NDArray[np.float64]:
    """(2, T) displacements in x and y of the frames' tiles against the expectation, from (2, T) guesses [px].

    The expectation is moved by whole pixels, for which nothing is interpolated. What is left is found by
    least squares on the mean slope of both pictures (Lucas & Kanade 1981), right but for the third power of
    half a pixel. Pictures are smoothed by binomials, which even out a mosaic.
    """
    spots = _spots(sample.capture)
    expected = _reference(sample, channel)
    frame = _with_slopes(_compared(sample)[..., channel])
    seen, *slopes = spots.centred(frame)
    moved = begun
    for _ in range(_STEPS):
        whole = np.rint(moved).astype(np.int64)
        there, *slopes_there = expected.pixels if not whole.any() else spots.centred(expected.images, whole)
        gain = _gain(spots, seen, there)
        means = [(a / gain + b) / 2 for a, b in zip(slopes, slopes_there, strict=True)]
        moved = whole + _least_squares(spots, seen / gain - there, means, slopes_there)
        if np.abs(moved - whole).max(initial=0.0) < _NEAR_PX:
            break
    return moved


@dataclass(frozen=True, eq=False)
class _Reference:
    """What frames are held against.

    Parameters
    ----------
    of
        (N, H, W, C) the expectation that it was made of.
    images
        (3, H, W) it smoothed, and its slopes in x and y.
    pixels
        (3, P) those of tiles; see `_Spots.centred`.
    """

    of: NDArray[np.float32]
    images: NDArray[np.float32]
    pixels: NDArray[np.float64]


_REFERENCES: WeakKeyDictionary[RealCapture, dict[int, _Reference]] = WeakKeyDictionary()


def _reference(sample: Sample, channel: int) -> _Reference:
    """Worked out once as long as the expectation is the same array."""
    known = _REFERENCES.setdefault(sample.capture, {})
    if channel not in known or known[channel].of is not sample.expected:
        full = np.float32(sample.capture.context.white_level_dn)
        images = _with_slopes(np.minimum(sample.expected[0][..., channel], full))
        known[channel] = _Reference(sample.expected, images, _spots(sample.capture).centred(images))
    return known[channel]


def _gain(spots: _Spots, seen: NDArray[np.float64], there: NDArray[np.float64]) -> NDArray[np.float64]:
    """(P,) contrast of each pixel's tile over what is expected."""
    power = np.maximum(spots.sums(there**2), 1e-9)
    return spots.spread(np.maximum(spots.sums(seen * there) / power, _LEAST_GAIN))


def _least_squares(
    spots: _Spots,
    left: NDArray[np.float64],
    slopes: Sequence[NDArray[np.float64]],
    noise_free: Sequence[NDArray[np.float64]],
) -> NDArray[np.float64]:
    """(2, T) moves that take away what is left, at most a pixel [px].

    Slopes without noise are the instruments (Wald 1940): the square of noisy ones would shorten moves.
    """
    xx, xy, yx, yy = (spots.sums(a * b) for a in noise_free for b in slopes)
    tx, ty = (-spots.sums(a * left) for a in noise_free)
    damping = _DAMPED * (xx + yy) + 1e-9
    xx, yy = xx + damping, yy + damping
    found = np.stack([yy * tx - xy * ty, xx * ty - yx * tx]) / (xx * yy - xy * yx)
    return np.asarray(np.clip(found, -1.0, 1.0))


def _with_slopes(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """(3, H, W) an image smoothed by binomials, and its slopes in x and y [1/px]."""
    import cv2

    smooth = _smoothed(image)
    one = np.ones(1, np.float32)
    slopes = [cv2.sepFilter2D(smooth, cv2.CV_32F, *taps) for taps in ((_SLOPE, one), (one, _SLOPE))]
    return np.stack([smooth, *slopes]).astype(np.float32)


def _smoothed(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """(H, W) an image smoothed by binomials, 1 4 6 4 1."""
    import cv2

    return np.asarray(cv2.GaussianBlur(np.ascontiguousarray(image), (5, 5), 0), np.float32)


def _compared(sample: Sample) -> NDArray[np.float32]:
    """(H, W, C) frames that are compared with the first expectation [DN]."""
    return sample.mean if len(sample.expected) == 1 else sample.frames[0]
