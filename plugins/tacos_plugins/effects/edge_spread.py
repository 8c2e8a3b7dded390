"""Spread of a straight edge, by the second moment of its line-spread function (ISO 12233, 6.2).

Against that of what is expected, so that the pixels' own width cancels. Moments of blurs of any kind add up.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Captures, ObservedCapture, structured

STEPS_PER_PX = 4
"""Bins of the distance from the edge, as the standard has them."""

STRIPS = 4
"""Parts of an edge that are measured by themselves."""

_REACH_PX = 12
_LEAST_REACH_PX = 3.0
_REACH_SPREADS = 3.5  # the moment is taken over so many spreads to either side
_LEAST_CONTRAST = 8.0  # over the noise-like scatter of a side, or DN
_LEAST_ROWS = 40
_OVERSHOOT = 0.03
"""Share of the contrast beyond either side, over a pixel, from which on sharpening took width away again."""


def edge_variances_px2(capture: ObservedCapture) -> list[float]:
    """Variance that blur adds to strips along a straight edge, the way across it [px^2].

    Empty where the capture has no straight edge, or too little of one, or a sharpened one: then its second
    moment tells of no blur.
    """
    strips = _strips_of(capture)
    return [_added_px2(*strip) for strip in strips if not _overshoots(strip[0])]


def are_sharpened(captures: Captures) -> bool:
    """Whether any straight edge leaves both of its sides, as light never does."""
    return any(_overshoots(real) for each in structured(captures) for real, _ in _strips_of(each))


def _strips_of(capture: ObservedCapture) -> list[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Profiles (B,) of the strips along a straight edge, real and expected."""
    if capture.edge_angle_deg is None or capture.expected_dn is None:
        return []
    real, expected = (
        each.mean(axis=(0, 3), dtype=np.float64) for each in (capture.real_dn, capture.expected_dn)
    )
    valid = capture.valid
    if np.abs(np.diff(expected, axis=0)).sum() > np.abs(np.diff(expected, axis=1)).sum():
        real, expected, valid = real.T, expected.T, valid.T
    distance = _distances_px(expected, valid)
    if distance is None:
        return []
    strips = [
        tuple(_profile(image[rows], distance[rows]) for image in (real, expected))
        for rows in np.array_split(np.arange(len(real)), STRIPS)
    ]
    return [(one, other) for one, other in strips if one is not None and other is not None]


def _added_px2(real: NDArray[np.float64], expected: NDArray[np.float64]) -> float:
    """Variance of one profile less that of the other, both as far out as the wider one reaches [px^2]."""
    reach = max(_REACH_SPREADS * _moment(real, _REACH_PX - 1.0) ** 0.5, _LEAST_REACH_PX)
    reach = min(reach, _REACH_PX - 1.0)
    return _moment(real, reach) - _moment(expected, reach)


def _overshoots(profile: NDArray[np.float64]) -> bool:
    """Whether a profile leaves both of its sides."""
    smooth = np.convolve(profile, np.full(STEPS_PER_PX, 1 / STEPS_PER_PX), "valid")
    return bool(smooth.max() > 1 + _OVERSHOOT and smooth.min() < -_OVERSHOOT)


def _distances_px(expected: NDArray[np.float64], valid: NDArray[np.bool_]) -> NDArray[np.float64] | None:
    """(H, W) distance from the line through the steepest places of rows; not a number off `valid`."""
    slopes = np.abs(np.diff(expected, axis=1)) * (valid[:, 1:] & valid[:, :-1])
    weight = np.where(slopes > 0.5 * slopes.max(initial=0.0), slopes, 0.0)
    total = weight.sum(axis=1)
    rows = np.flatnonzero(total > 0)
    if len(rows) < _LEAST_ROWS:
        return None
    x = np.arange(slopes.shape[1]) + 0.5
    slope, offset = np.polyfit(rows, weight[rows] @ x / total[rows], 1)
    y, columns = np.mgrid[: expected.shape[0], : expected.shape[1]]
    distance = (columns - slope * y - offset) / np.hypot(1, slope)
    return np.where(valid, distance, np.nan)


def _profile(image: NDArray[np.float64], distance: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """(B,) mean across an edge, from 0 to 1; each row between its own sides, as light falls off along it."""
    sides = []
    for low, high in ((-_REACH_PX, -_REACH_PX / 2), (_REACH_PX / 2, _REACH_PX)):
        inside = (distance > low) & (distance < high)
        count = inside.sum(axis=1)
        sides.append(np.where(inside, image, 0).sum(axis=1) / np.where(count, count, np.nan))
    contrast = sides[1] - sides[0]
    if not np.nanmin(np.abs(contrast), initial=np.inf) > _LEAST_CONTRAST:
        return None
    share = (image - sides[0][:, None]) / contrast[:, None]
    used = np.isfinite(share) & (np.abs(distance) < _REACH_PX)
    bins = ((distance[used] + _REACH_PX) * STEPS_PER_PX).astype(np.int64)
    count = np.bincount(bins, minlength=2 * _REACH_PX * STEPS_PER_PX)
    if not count.all():
        return None
    return np.asarray(np.bincount(bins, share[used], len(count)) / count)


def _moment(profile: NDArray[np.float64], reach_px: float) -> float:
    """Variance of the line-spread function within a distance of its middle [px^2]."""
    spread = np.diff(profile)
    x = (np.arange(len(spread)) + 1) / STEPS_PER_PX - _REACH_PX
    middle = 0.0
    for _ in range(3):
        near = np.abs(x - middle) < reach_px
        middle = float(np.sum(x[near] * spread[near]) / np.sum(spread[near]))
    near = np.abs(x - middle) < reach_px
    return max(float(np.sum((x[near] - middle) ** 2 * spread[near]) / np.sum(spread[near])), 0.0)
