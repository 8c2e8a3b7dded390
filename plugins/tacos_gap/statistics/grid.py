"""Bins and tiles of an image, made once per capture."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from tacos_gap.captures import RealCapture
from tacos_gap.captures.mean_of_files import averaged_expectation, noise_of_average
from tacos_gap.statistics.block import expected_signal
from tacos_gap.statistics.line_means import over_image
from tacos_gap.statistics.masked import only_in

TILE_ROWS, TILE_COLUMNS = 6, 8
RINGS = (0.0, 0.35, 0.6, 0.8, np.inf)
"""Borders of rings around the principal point, which may lie off the file: radius over half the diagonal."""

LEVELS = 6
SMALLEST_BIN = 200  # pixels

EVEN_DN = 2.0
"""Range of what is expected below which a capture has one level [DN]."""

EXTREMES = 8.0
"""Standard deviations between the extremes of a Gaussian, of some 20,000 independent values."""

NOISY_EDGE = 1.7
"""Gradient that the noise of such an average reaches in one pixel of a million, over its deviation: averages
two pixels apart differ by two thirds of it only, as their windows overlap."""


@dataclass(frozen=True, eq=False)
class Bins:
    index: NDArray[np.int64]  # (H, W) the bin each pixel is in; -1 for none
    at: Sequence[Mapping[str, Any]]  # what each bin is
    count: NDArray[Any]
    kept: NDArray[np.int64]
    """(B,) its number among those that were made, before those with too few pixels were left out."""
    _parts: dict[bytes, Bins] = field(default_factory=dict, repr=False)

    def mean(self, image: NDArray[np.floating]) -> NDArray[np.float64]:
        """Mean of an (H, W) image in each bin."""
        if self._covers_all:
            return over_image(image[..., None])
        from tacos_gap.statistics.bin_loops import add_up

        sums = np.zeros(len(self.at) + 1)  # the first of what is in no bin
        add_up(self._places, image, sums)
        return np.asarray(sums[1:] / self.count)

    def in_rows(self, rows: NDArray[np.int64]) -> Bins:
        """The bins of an image that has some of the rows alone; means of those it lacks are not numbers."""
        if rows.size == len(self.index):
            return self
        key = rows.tobytes()
        if key not in self._parts:
            index = self.index[rows.ravel()]
            count = np.bincount(index.ravel() + 1, minlength=len(self.at) + 1)[1:]
            self._parts[key] = Bins(index, self.at, np.where(count, count, np.nan), self.kept)
        return self._parts[key]

    @cached_property
    def _places(self) -> NDArray[np.int32]:
        return (self.index + 1).astype(np.int32)

    @cached_property
    def _covers_all(self) -> bool:
        return len(self.at) == 1 and bool((self.index == 0).all())


_KEPT: WeakKeyDictionary[RealCapture, dict[Any, Bins]] = WeakKeyDictionary()


def _kept(capture: RealCapture, key: Any, make: Any) -> Bins:
    bins = _KEPT.setdefault(capture, {})
    if key not in bins:
        bins[key] = make()
    return bins[key]


_EXPECTED: WeakKeyDictionary[Bins, dict[int, NDArray[np.float64]]] = WeakKeyDictionary()


def expected_in(bins: Bins, capture: RealCapture, channel: int) -> NDArray[np.float64]:
    """(B,) mean of what is expected above the pedestal in bins of a capture; worked out once [DN]."""
    known = _EXPECTED.setdefault(bins, {})
    if channel not in known:
        known[channel] = bins.mean(expected_signal(capture)[..., channel])
    return known[channel]


def _compact(index: NDArray[np.int64], at: Sequence[Mapping[str, Any]]) -> Bins:
    count = np.bincount(index.ravel() + 1, minlength=len(at) + 1)[1:]
    keep = np.flatnonzero(count >= min(SMALLEST_BIN, max(count.max(initial=0) // 4, 1)))
    renamed = np.full(len(at) + 1, -1)
    renamed[keep + 1] = np.arange(len(keep))
    return Bins(renamed[index + 1], [at[k] for k in keep.tolist()], count[keep], keep)


def tiles(capture: RealCapture) -> Bins:
    """Tiles of the image, row by row."""

    def make() -> Bins:
        height, width = capture.valid.shape
        rows = np.arange(height)[:, None] * TILE_ROWS // height
        columns = np.arange(width)[None, :] * TILE_COLUMNS // width
        index = np.where(capture.valid, rows * TILE_COLUMNS + columns, -1)
        at = []
        for r in range(TILE_ROWS):
            for c in range(TILE_COLUMNS):
                box = [
                    c * width // TILE_COLUMNS,
                    r * height // TILE_ROWS,
                    (c + 1) * width // TILE_COLUMNS,
                    (r + 1) * height // TILE_ROWS,
                ]
                at.append({"box_px": box, "radius": _radius_of(capture, box)})
        return _compact(index, at)

    return _kept(capture, "tiles", make)


def tile_means(capture: RealCapture, image: NDArray[np.float32]) -> NDArray[np.float64]:
    """(T, C) mean of each channel of an (H, W, C) image in `tiles`, all of them at once.

    Sums along rows are one product of matrices: an order of magnitude faster than counting pixel by pixel.
    """
    grid = tiles(capture)
    height, width, channels = image.shape
    samples = only_in(capture.valid, image).reshape(height, width * channels)
    along = samples @ _columns_of_tiles(width, channels)
    first_rows = [-(-r * height // TILE_ROWS) for r in range(TILE_ROWS)]
    sums = np.add.reduceat(along, first_rows, axis=0, dtype=np.float64)
    return np.asarray(sums.reshape(-1, channels)[grid.kept] / grid.count[:, None])


@lru_cache(maxsize=8)
def _columns_of_tiles(width: int, channels: int) -> NDArray[np.float32]:
    """(W C, T C) which tile and channel each sample of a row is counted in."""
    tile = np.arange(width) * TILE_COLUMNS // width
    member = np.zeros((width, channels, TILE_COLUMNS, channels), np.float32)
    for channel in range(channels):
        member[np.arange(width), channel, tile, channel] = 1
    return member.reshape(width * channels, TILE_COLUMNS * channels)


def _radius_of(capture: RealCapture, box: Sequence[int]) -> list[float]:
    inside = capture.geometry.radius[box[1] : box[3], box[0] : box[2]]
    return [round(float(inside.min()), 2), round(float(inside.max()), 2)] if inside.size else [0.0, 0.0]


def rings(capture: RealCapture) -> Bins:
    """Rings around the principal point."""

    def make() -> Bins:
        index = np.searchsorted(RINGS, capture.geometry.radius, side="right") - 1
        index = np.where(capture.valid, index, -1)
        at = [{"radius": [inner, min(outer, 1.0)]} for inner, outer in pairwise(RINGS)]
        return _compact(index, at)

    return _kept(capture, "rings", make)


def levels(capture: RealCapture, channel: int, flat: NDArray[np.bool_] | None = None) -> Bins:
    """Bins of the expected level; one bin where the capture is even.

    Of a noisy expectation neighbours are averaged first, see `averaged_expectation`.

    `flat` restricts them to pixels where it holds.
    """

    def make() -> Bins:
        assert capture.expected_dn is not None
        level = capture.expected_dn.mean(axis=0)[..., channel]
        noise_dn = 0.0
        if capture.expected_frames:
            level = averaged_expectation(capture)[..., channel]
            noise_dn = float(noise_of_average(capture)[channel])
        use = capture.valid if flat is None else capture.valid & flat
        inside = level[use]
        if not inside.size:
            return _compact(np.full(level.shape, -1), [])
        if np.ptp(inside) < EVEN_DN + EXTREMES * noise_dn:
            return _compact(np.where(use, 0, -1), [{"level_dn": round(float(inside.mean()), 1)}])
        edges = np.unique(np.quantile(inside, np.linspace(0, 1, LEVELS + 1)))
        index = np.clip(np.searchsorted(edges, level, side="right") - 1, 0, len(edges) - 2)
        at = [{"level_dn": [round(float(a), 1), round(float(b), 1)]} for a, b in pairwise(edges)]
        return _compact(np.where(use, index, -1), at)

    return _kept(capture, ("levels", channel, flat is None), make)


LEAST_SIDE_PX = 16
"""Side of an image below which nothing is measured in it: rows, tiles and neighbours need room."""

LEAST_EVEN = 2000
"""Pixels without edges that it takes to measure noise and fixed patterns."""


def has_even_areas(capture: RealCapture) -> bool:
    """True if enough of the expectation is free of edges to see fixed patterns, or noise in one frame."""
    return int(np.count_nonzero(smooth_areas(capture) & capture.valid)) >= LEAST_EVEN


_SMOOTH: WeakKeyDictionary[RealCapture, NDArray[np.bool_]] = WeakKeyDictionary()


def smooth_areas(capture: RealCapture) -> NDArray[np.bool_]:
    """(H, W) where the expectation has no edges: noise can be seen there in a single frame."""
    if capture not in _SMOOTH:
        _SMOOTH[capture] = _without_edges(capture)
    return _SMOOTH[capture]


def _without_edges(capture: RealCapture) -> NDArray[np.bool_]:
    import cv2

    assert capture.expected_dn is not None
    level = capture.expected_dn.mean(axis=0).max(axis=-1)
    noise_dn = 0.0
    if capture.expected_frames:
        level = averaged_expectation(capture).max(axis=-1)
        noise_dn = float(noise_of_average(capture).max())
    range_of = np.maximum(np.ptp(level), 1.0)
    gy, gx = np.gradient(level)
    edgy = np.hypot(gx, gy) > 0.01 * range_of + 0.25 + NOISY_EDGE * noise_dn
    return ~cv2.dilate(edgy.astype(np.uint8), np.ones((9, 9), np.uint8)).astype(bool)
