"""Noise of one frame in the even areas of its target: what departs from the middle of its neighbourhood."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_gap.captures.capture import Noise, RealCapture

WINDOW_PX = 15
"""Side of the neighbourhood: processed noise is correlated over a few pixels, which a high-pass misses."""

_CLEAR_OF_EDGES_PX = 12
_LEAST_PIXELS = 400
_CLIPPED = 0.95


def even_noise(capture: RealCapture) -> Noise | None:
    """A line of variance against signal through the even areas of a single frame, per channel.

    Fixed patterns and the texture of the target count as noise, as nothing in one frame tells them apart.

    - `capture`: with an expectation, whose even areas are used.

    Returns None where too little of the target is even.
    """
    assert capture.expected_dn is not None
    expected, real = capture.expected_dn.mean(axis=0), capture.real_dn[0]
    context = capture.context
    span = context.white_level_dn - context.black_level_dn
    even = _even(expected, capture.valid, 0.004 * span)
    photon, thermal = [], []
    for channel in range(real.shape[-1]):
        plane = np.ascontiguousarray(real[..., channel])
        inside = even & (plane < context.black_level_dn + _CLIPPED * span)
        share = _mean(even.astype(np.float32))
        level = _mean(np.where(even, plane, 0)) / np.maximum(share, 1e-6)
        inside &= share > 0.9
        if inside.sum() < _LEAST_PIXELS:
            return None
        size = WINDOW_PX**2
        square = np.square(plane - level)[inside] * size / (size - 1)
        slope, intercept = _line(level[inside] - context.black_level_dn, square, span)
        photon.append(slope)
        thermal.append(intercept)
    return Noise(tuple(photon), tuple(thermal), known=False)


def _even(expected: NDArray[np.float32], valid: NDArray[np.bool_], step_dn: float) -> NDArray[np.bool_]:
    """(H, W) where a target is even and the blur of its edges does not reach."""
    level = np.ascontiguousarray(expected.max(axis=-1))
    near = np.ones((3, 3), np.uint8)
    steps = cv2.dilate(level, near) - cv2.erode(level, near) > step_dn
    reach = min(_CLEAR_OF_EDGES_PX, max(1, min(valid.shape) // 16))
    window = np.ones((2 * reach + 1,) * 2, np.uint8)
    return np.asarray(cv2.erode((valid & ~steps).astype(np.uint8), window), bool)


def _mean(plane: NDArray[np.float32]) -> NDArray[np.float32]:
    return np.asarray(cv2.blur(plane, (WINDOW_PX, WINDOW_PX), borderType=cv2.BORDER_REFLECT))


def _line(signal: NDArray[np.floating], square: NDArray[np.floating], span: float) -> tuple[float, float]:
    """Slope and intercept of variance over signal; no slope where all is of one level."""
    edges = np.quantile(signal, np.linspace(0, 1, 9))
    which = np.clip(np.searchsorted(edges, signal, side="right") - 1, 0, 7)
    filled = [k for k in range(8) if (which == k).sum() >= 50]
    x = np.array([signal[which == k].mean() for k in filled])
    y = np.array([np.median(square[which == k]) / 0.455 for k in filled])  # of a squared Gaussian's mean
    if len(x) < 2 or np.ptp(x) < 0.1 * span:
        return 0.0, max(float(np.mean(square)), 0.01)
    slope, intercept = np.polyfit(x, y, 1, w=1 / np.maximum(y, 0.05))
    slope = max(float(slope), 0.0)
    return slope, max(float(intercept if slope else y.mean()), 0.01)
