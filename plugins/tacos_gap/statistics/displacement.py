"""Displacement of things against where they are expected, per channel.

Dense flow finds large displacements, but jumps as noise and shape have it: a picture moved by a fiftieth of a
pixel by an effect and by a nuisance gave numbers 60 % apart. So flow is where least squares begin, whose end
is a smooth function of the frames; those of red and blue begin where green was found. Most effects move
nothing: where least squares from there account for what is seen, no flow is looked for.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from tacos_gap.captures import RealCapture
from tacos_gap.statistics.block import Sample, StatisticBlock
from tacos_gap.statistics.flow import ASTRAY_PX, dense_flow, smooth_field
from tacos_gap.statistics.textured_tiles import TexturedTiles, textured_tiles

AMPLITUDE_PX = 0.03
"""Equivalence margin: smaller displacements are negligible [px]."""

_LEAST_SIDE_PX = 32
"""Side of an image below which no flow is looked for."""

_STEPS = 3
"""Least squares at most; a further one where the last shows that it began far off."""

_NEAR_PX = 0.75
"""A move beyond the whole pixels by less is as good as from the pixels nearest to it."""

_AT_REST_PX = 0.5
"""A tile that moved by less is looked for where it was expected."""

_LEFT_AT_REST = 0.25
"""Share of a tile's contrast, squared, that may be left there."""

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
    textured = textured_tiles(capture)
    colour = len(sample.channels) == 3
    if capture.own_edges and not colour:
        return
    channel = 1 if colour else 0
    green = _displacements(sample, channel, lambda: _begun(sample, channel))
    if not capture.own_edges:
        for values, axis in zip(green, "xy", strict=True):
            at = [{**a, "axis": axis} for a in textured.at]
            yield StatisticBlock("displacement", "optics", values, at, AMPLITUDE_PX)
    if colour:
        for channel, name in ((0, "R-G"), (2, "B-G")):
            apart = _displacements(sample, channel, lambda: green) - green
            for values, axis in zip(apart, "xy", strict=True):
                places = [{**a, "axis": axis, "channels": name} for a in textured.at]
                yield StatisticBlock("colour_displacement", "optics", values, places, AMPLITUDE_PX)


def has_texture(capture: RealCapture) -> bool:
    return min(capture.valid.shape) >= _LEAST_SIDE_PX and bool(textured_tiles(capture).parts)


def _begun(sample: Sample, channel: int) -> NDArray[np.float64]:
    """(2, T) dense flow of the tiles, or its smooth field where flow went astray and the field fits [px]."""
    textured = textured_tiles(sample.capture)
    flow = textured.medians(dense_flow(sample, _compared(sample), channel))
    field = smooth_field(textured.middles_px, flow)
    if np.abs(flow - field).max(initial=0.0) < ASTRAY_PX:
        return flow
    seen = textured.centred(_smoothed(_compared(sample)[..., channel])[None])[0]
    smooth = _reference(sample, channel).images[:1]
    left = []
    for begun in (flow, field):
        there = textured.centred(smooth, np.rint(begun).astype(np.int64))[0]
        left.append(textured.sums((seen - _gain(textured, seen, there) * there) ** 2))
    return np.where(left[1] < left[0], field, flow)


def _displacements(
    sample: Sample, channel: int, begun: Callable[[], NDArray[np.float64]]
) -> NDArray[np.float64]:
    """(2, T) displacements in x and y of the frames' tiles against the expectation [px].

    The expectation is moved by whole pixels, for which nothing is interpolated. What is left is found by
    least squares on the mean slope of both pictures (Lucas & Kanade 1981), right but for the third power of
    half a pixel. Pictures are smoothed by binomials, which even out a mosaic.

    `begun`: (2, T) guesses, asked for where tiles are not found within half a pixel of what is expected [px].
    """
    textured = textured_tiles(sample.capture)
    expected = _reference(sample, channel)
    frame = textured.centred(_with_slopes(_compared(sample)[..., channel]))
    moved, left = _moved(textured, frame, expected.pixels)
    if np.abs(moved).max(initial=0.0) < _AT_REST_PX and left.max(initial=0.0) < _LEFT_AT_REST:
        return moved
    moved = begun()
    for _ in range(_STEPS):
        whole = np.rint(moved).astype(np.int64)
        there = expected.pixels if not whole.any() else textured.centred(expected.images, whole)
        moved = whole + _moved(textured, frame, there)[0]
        if np.abs(moved - whole).max(initial=0.0) < _NEAR_PX:
            break
    return _as_far_as_seen(textured, moved, expected.pixels[1:])


def _as_far_as_seen(
    textured: TexturedTiles, moves: NDArray[np.float64], slopes: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(2, T) moves less what leads along an edge, where any is as good as none [px].

    `moves`: (2, T) moves [px]. `slopes`: (2, P) slopes in x and y of what is expected; their squares say
    along which axes moves are seen.
    """
    squares = np.array([[textured.sums(a * b) for b in slopes] for a in slopes])
    squares = np.moveaxis(squares, -1, 0) / np.maximum(squares[0, 0] + squares[1, 1], 1e-9)[:, None, None]
    squared = squares @ squares
    seen = np.linalg.solve(squared + _DAMPED**2 * np.eye(2), squared @ moves.T[..., None])
    return np.asarray(seen[..., 0].T)


def _moved(
    textured: TexturedTiles, frame: NDArray[np.float64], expected: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(2, T) moves of tiles by least squares [px], and the (T,) share of their squares that these leave.

    Of (3, P) pixels and their slopes in x and y, seen and expected.
    """
    (seen, *slopes), (there, *slopes_there) = frame, expected
    gain = _gain(textured, seen, there)
    means = [(a / gain + b) / 2 for a, b in zip(slopes, slopes_there, strict=True)]
    left = seen / gain - there
    moves = _least_squares(textured, left, means, slopes_there)
    still = left + textured.spread(moves[0]) * means[0] + textured.spread(moves[1]) * means[1]
    return moves, textured.sums(still**2) / np.maximum(textured.sums(there**2), 1e-9)


@dataclass(frozen=True, eq=False)
class _Reference:
    of: NDArray[np.float32]  # (N, H, W, C) the expectation that it was made of
    images: NDArray[np.float32]  # (3, H, W) it smoothed, and its slopes in x and y
    pixels: NDArray[np.float64]  # (3, P) those of tiles; see `TexturedTiles.centred`


_REFERENCES: WeakKeyDictionary[RealCapture, dict[int, _Reference]] = WeakKeyDictionary()


def _reference(sample: Sample, channel: int) -> _Reference:
    """Worked out once as long as the expectation is the same array."""
    known = _REFERENCES.setdefault(sample.capture, {})
    if channel not in known or known[channel].of is not sample.expected:
        full = np.float32(sample.capture.context.white_level_dn)
        images = _with_slopes(np.minimum(sample.expected[0][..., channel], full))
        known[channel] = _Reference(sample.expected, images, textured_tiles(sample.capture).centred(images))
    return known[channel]


def _gain(
    textured: TexturedTiles, seen: NDArray[np.float64], there: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(P,) contrast of each pixel's tile over what is expected."""
    power = np.maximum(textured.sums(there**2), 1e-9)
    return textured.spread(np.maximum(textured.sums(seen * there) / power, _LEAST_GAIN))


def _least_squares(
    textured: TexturedTiles,
    left: NDArray[np.float64],
    slopes: Sequence[NDArray[np.float64]],
    noise_free: Sequence[NDArray[np.float64]],
) -> NDArray[np.float64]:
    """(2, T) moves that take away what is left, at most a pixel [px].

    Slopes without noise are the instruments (Wald 1940): the square of noisy ones would shorten moves.
    """
    xx, xy, yx, yy = (textured.sums(a * b) for a in noise_free for b in slopes)
    tx, ty = (-textured.sums(a * left) for a in noise_free)
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
