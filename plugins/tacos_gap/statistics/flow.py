"""Dense flow from an expectation to frames, tile by tile, and what is smooth of it.

Flow jumps to whatever looks alike: in a picture out of focus, tiles go tens of pixels astray. Lenses, poses
and moving cameras bend pictures smoothly, so that a smooth field through the flow of all tiles is the other
place to begin at.
"""

from __future__ import annotations

from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from tacos_gap.captures import RealCapture
from tacos_gap.statistics.block import Sample

ASTRAY_PX = 1.0
"""Distance of a tile's flow from the smooth field from which on both are tried [px]."""

_ROUNDS = 12
"""Rounds of reweighting, after which weights hardly move."""

_TILES_PER_TERM = 3
"""Tiles that a term of the field takes at least."""


def smooth_field(places: NDArray[np.float64], flow: NDArray[np.float64]) -> NDArray[np.float64]:
    """The polynomial through the flow of most tiles; of degree 3, or as many as their number bears.

    Least absolute deviations, by reweighted least squares (Schlossmacher 1973), so that tiles that went
    astray do not matter.

    - `places`: (T, 2) middles of tiles, of any unit.
    - `flow`: (2, T) their displacements [px].

    Returns: (2, T) the field there [px].
    """
    if not len(places):
        return flow
    x, y = ((places - places.mean(axis=0)) / max(float(np.ptp(places)), 1e-9)).T
    degree = max(d for d in range(4) if d == 0 or (d + 1) * (d + 2) / 2 * _TILES_PER_TERM <= len(x))
    terms = np.stack([x**i * y**j for i in range(degree + 1) for j in range(degree + 1 - i)], axis=1)
    weights = np.ones(len(x))
    field = flow
    for _ in range(_ROUNDS):
        root = np.sqrt(weights)[:, None]
        coefficients, *_ = np.linalg.lstsq(terms * root, flow.T * root, rcond=None)
        field = (terms @ coefficients).T
        weights = 1 / np.maximum(np.hypot(*(flow - field)), 0.01)
    return field


def dense_flow(sample: Sample, frames: NDArray[np.float32], channel: int) -> NDArray[np.float32]:
    """Flow from the expectation to frames (Kroeger et al. 2016, DIS), (H, W, 2) [px].

    `frames`: (H, W, C) what is looked at [DN].
    """
    import cv2

    first = _stretched_expectation(sample, channel)
    second = _stretched(frames[..., channel])
    search = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_FAST)
    search.setFinestScale(1)
    search.setVariationalRefinementIterations(0)  # twice the time; medians over tiles hardly change
    return np.asarray(search.calc(first, second, np.zeros((*first.shape, 2), np.float32)))


_STRETCHED: WeakKeyDictionary[RealCapture, dict[int, tuple[NDArray[np.float32], NDArray[np.uint8]]]] = (
    WeakKeyDictionary()
)


def _stretched_expectation(sample: Sample, channel: int) -> NDArray[np.uint8]:
    """Reference of frames, worked out once as long as it is the same array."""
    known = _STRETCHED.setdefault(sample.capture, {})
    if channel not in known or known[channel][0] is not sample.expected:
        known[channel] = sample.expected, _stretched(sample.expected[0][..., channel])
    return known[channel][1]


def _stretched(image: NDArray[np.float32]) -> NDArray[np.uint8]:
    """An image stretched over 8 bits, but for its extremes; a sixteenth of the pixels tells its range."""
    low, high = np.percentile(image[2::4, 2::4], (0.5, 99.5))
    gain = 255 / max(float(high - low), 1.0)
    return np.asarray(np.clip((image - np.float32(low)) * np.float32(gain), 0, 255).astype(np.uint8))
