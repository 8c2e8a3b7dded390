"""A straight slanted edge: its line, its spread, and the sharp edge it would be."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

OVERSAMPLING = 4
"""Bins of the edge spread function per pixel (ISO 12233:2017, annex D)."""

PLATEAU_PX = 12.0
"""Distance from the edge from which on its sides are even, whatever the blur of a picture worth measuring."""

_REACH_PX = 32.0
_STRAIGHT_PX = 0.6
"""Scatter of the crossings about a line above which an edge is no straight one."""

_EVEN = 0.12
"""Scatter of either side over the contrast above which the picture shows more than an edge."""


@dataclass(frozen=True)
class SlantedEdge:
    """A straight edge between two sides."""

    normal: tuple[float, float]  # unit vector (x, y) from the dark side to the bright one
    offset_px: float
    """Where the edge crosses it: points on the edge have ``normal . (x, y) = offset_px`` [px]."""
    angle_deg: float  # from the nearest image axis [deg]

    def distance_px(self, shape: tuple[int, int]) -> NDArray[np.float64]:
        """(H, W) signed distance of pixel centres, positive on the bright side [px]."""
        y, x = np.ogrid[: shape[0], : shape[1]]
        return np.asarray(self.normal[0] * x + self.normal[1] * y - self.offset_px)


def find_edge(plane: NDArray[np.floating]) -> SlantedEdge | None:
    """The one straight edge of a picture; None where there is none, or more than that.

    Crossings of the middle level, row by row or column by column, to a fraction of a pixel, through which a
    line goes that outliers do not pull.

    `plane`: (H, W) linear values of one channel.
    """
    image = np.asarray(plane, np.float32)
    if min(image.shape) < 16:
        return None
    smooth = np.asarray(cv2.GaussianBlur(image, (0, 0), 1.0), np.float32)
    low, high = np.percentile(smooth, (5, 95))
    if high - low < 4 * max(float(np.std(image - smooth)), 1e-6):
        return None
    across = abs(float(np.diff(smooth, axis=1).sum())) * image.shape[1]
    down = abs(float(np.diff(smooth, axis=0).sum())) * image.shape[0]
    upright = across >= down
    points = _crossings(smooth if upright else smooth.T, (float(low) + float(high)) / 2)
    if points is None:
        return None
    if (line := _line(points, upright)) is None:
        return None
    levelled = _levelled(smooth, line)
    if (points := _crossings(levelled if upright else levelled.T, 0.5)) is not None:
        line = _line(points, upright) or line  # uneven light moves where one level is passed
    return _with_even_sides(image, line)


def _line(points: NDArray[np.float64], upright: bool) -> SlantedEdge | None:
    """The line through (K, 2) crossings, its normal either way; None where they lie on no line."""
    line, places = points[:, 0], points[:, 1]
    direction = cv2.fitLine(points.astype(np.float32), cv2.DIST_HUBER, 0, 1e-3, 1e-3).ravel()
    slope = float(direction[1] / direction[0]) if abs(direction[0]) > 1e-6 else np.inf
    if not np.isfinite(slope) or abs(slope) > 1.05:
        return None
    start = float(direction[3] - slope * direction[2])
    if np.sqrt(np.mean((places - start - slope * line) ** 2)) > _STRAIGHT_PX:
        return None
    size = float(np.hypot(1.0, slope))
    normal = (1 / size, -slope / size) if upright else (-slope / size, 1 / size)
    return SlantedEdge(normal, start / size, float(np.degrees(np.arctan(slope))))


def _levelled(image: NDArray[np.float32], edge: SlantedEdge) -> NDArray[np.float32]:
    """(H, W) values from 0 on one side of an edge to 1 on the other, whatever the light on either."""
    distance = edge.distance_px(image.shape)
    near = np.abs(distance) < 3 * _REACH_PX
    if any((near & (sign * distance > PLATEAU_PX)).sum() < 50 for sign in (1, -1)):
        return image
    values = image.astype(np.float64)
    one, other = (_side(values, sign * distance > PLATEAU_PX, near) for sign in (-1, 1))
    apart = other - one
    levelled = (image - one) / np.where(np.abs(apart) < 1e-6, 1e-6, apart)
    beyond = np.clip(distance, 0.0, 1.0)  # far off, sides that are no smooth ones say nothing
    return np.asarray(np.where(near, levelled, beyond), np.float32)


def _with_even_sides(image: NDArray[np.float32], edge: SlantedEdge) -> SlantedEdge | None:
    """The edge from its dark to its bright side; None where the picture shows more than an edge."""
    normal = edge.normal
    distance = edge.distance_px(image.shape)
    if image[distance > 0].mean() < image[distance < 0].mean():
        edge = SlantedEdge((-normal[0], -normal[1]), -edge.offset_px, edge.angle_deg)
        distance = -distance
    sides = [image[np.abs(distance - sign * 1.5 * PLATEAU_PX) < PLATEAU_PX / 2] for sign in (1, -1)]
    far = [image[sign * distance > PLATEAU_PX] for sign in (1, -1)]
    if any(side.size < 50 for side in sides):
        return None
    contrast = float(sides[0].mean() - sides[1].mean())
    return edge if all(side.std() < _EVEN * contrast for side in far) else None


def sharp_edge(
    plane: NDArray[np.floating], edge: SlantedEdge
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """(H, W) the edge without any blur between its two smooth sides, and (H, W) where it says so.

    A pixel on the edge has the share of either side that covers it.
    """
    image = np.asarray(plane, np.float64)
    distance = edge.distance_px(image.shape)
    width = abs(edge.normal[0]) + abs(edge.normal[1])
    share = np.clip(0.5 + distance / width, 0.0, 1.0)
    near = np.abs(distance) < 3 * _REACH_PX
    dark, bright = (_side(image, sign * distance > PLATEAU_PX, near) for sign in (-1, 1))
    return np.asarray(dark * (1 - share) + bright * share, np.float32), near


def edge_spread(plane: NDArray[np.floating], edge: SlantedEdge) -> tuple[NDArray[np.float64], ...]:
    """Distances and levels of the oversampled edge spread function: (K,) [px] and (K,) from 0 to 1.

    The mean level of a bin is that at the mean place of its pixels, not at its middle: along an edge whose
    slope is a fraction such as 1/8, pixels lie at a few places of each bin and no others.
    """
    image = np.asarray(plane, np.float64)
    distance = edge.distance_px(image.shape)
    inside = np.abs(distance) < _REACH_PX
    which = np.floor((distance[inside] + _REACH_PX) * OVERSAMPLING).astype(int)
    count = np.bincount(which, minlength=int(2 * _REACH_PX * OVERSAMPLING))
    filled = count > 0
    reached, found = (
        np.bincount(which, each[inside], len(count))[filled] / count[filled] for each in (distance, image)
    )
    places = (np.arange(len(count)) + 0.5) / OVERSAMPLING - _REACH_PX
    levels = np.interp(places, reached, found)
    low = levels[places < max(-PLATEAU_PX, float(reached[0]) + 2)].mean()
    high = levels[places > min(PLATEAU_PX, float(reached[-1]) - 2)].mean()
    return places, (levels - low) / (high - low)


def edge_sfr(plane: NDArray[np.floating], edge: SlantedEdge) -> tuple[NDArray[np.float64], ...]:
    """Spatial frequencies and response of a slanted edge: (K,) [cycles/px] and (K,) 1 at 0.

    Derivative of the edge spread function, Hamming window, Fourier transform, and the response of the
    derivative's difference divided out (ISO 12233:2017, annex D).
    """
    places, levels = edge_spread(plane, edge)
    spread = np.gradient(levels)
    spread *= 0.54 + 0.46 * np.cos(np.pi * places / _REACH_PX)
    transform = np.abs(np.fft.rfft(spread))
    frequency = np.fft.rfftfreq(len(spread), 1 / OVERSAMPLING)
    difference = np.sinc(2 * frequency / OVERSAMPLING)  # of a central difference over two bins
    used = frequency <= 1.0
    response = transform[used] / transform[0] / np.maximum(difference[used], 0.1)
    return np.asarray(frequency[used], np.float64), np.asarray(response, np.float64)


def mtf50_cycles_px(plane: NDArray[np.floating], edge: SlantedEdge) -> float:
    """The frequency at which the contrast has fallen to a half [cycles/px]; nan where it never does."""
    frequency, response = edge_sfr(plane, edge)
    below = np.flatnonzero(response < 0.5)
    if not len(below) or below[0] == 0:
        return float("nan")
    k = int(below[0])
    step = (response[k - 1] - 0.5) / (response[k - 1] - response[k])
    return float(frequency[k - 1] + step * (frequency[k] - frequency[k - 1]))


def overshoot(plane: NDArray[np.floating], edge: SlantedEdge) -> float:
    """Spread beyond the two sides over the contrast, which sharpening leaves [1]."""
    places, levels = edge_spread(plane, edge)
    near = np.abs(places) < PLATEAU_PX
    smooth = np.convolve(levels, np.full(OVERSAMPLING, 1 / OVERSAMPLING), "same")[near]
    return float(max(smooth.max() - 1, -smooth.min(), 0.0))


def _crossings(image: NDArray[np.float32], level: float) -> NDArray[np.float64] | None:
    """(K, 2) row, and the column where it passes a level; None where most rows do not pass it once."""
    above = image > level
    turns = np.diff(above.astype(np.int8), axis=1) != 0
    once = np.flatnonzero(turns.sum(axis=1) == 1)
    if len(once) < max(10, 0.5 * len(image)):
        return None
    column = turns[once].argmax(axis=1)
    before, after = image[once, column], image[once, column + 1]
    places = column + (level - before) / (after - before)
    return np.column_stack([once, places]).astype(np.float64)


def _side(
    image: NDArray[np.float64], side: NDArray[np.bool_], near: NDArray[np.bool_]
) -> NDArray[np.float64]:
    """(H, W) one side of an edge as smooth as lenses and lamps make it, of second order."""
    height, width = image.shape
    y, x = np.linspace(-1, 1, height), np.linspace(-1, 1, width)
    used = side & near
    rows, columns = np.nonzero(used)
    v, u = y[rows], x[columns]
    terms = np.stack([np.ones_like(u), u, v, u * u, u * v, v * v])
    a, b, c, d, e, f = np.linalg.solve(terms @ terms.T + 1e-6 * len(u) * np.eye(6), terms @ image[used])
    down = y[:, None]
    return np.asarray((a + b * x + d * x * x) + down * (c + e * x) + f * down * down)
