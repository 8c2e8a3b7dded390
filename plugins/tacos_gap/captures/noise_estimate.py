"""Noise of real frames, where the simulator's is unknown."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from tacos_gap.captures.capture import Noise, RealCapture
from tacos_gap.captures.rounding import are_whole, before_rounding

BINS = 12
ENOUGH_PIXELS = 1_500_000
"""Pixels of a frame beyond which a part of them is looked at: 12 bins of 125,000 know a variance to 0.4 %."""

_CENSORED = 0.6
"""Share of zeros above which the lower half of the noise is taken to be cut off."""

_NOISE_DN = 3.0
_LEAST_DN2 = 0.01
_MEDIAN_TO_SPREAD = 1.4826
"""Standard deviation of normal values over their median absolute value."""

_STILL = 4.0
"""Spreads from the middle beyond which something moved."""

_FEWEST_IN_LINE = 8
"""Pixels of a row or column from which on their mean tells an offset of the line from their own noise."""

_LAPLACIAN_GAIN = 36.0
"""Sum of squares of the kernel [[1, -2, 1], [-2, 4, -2], [1, -2, 1]] (Immerkaer 1996)."""


def estimate_noise(capture: RealCapture) -> Noise:
    """A straight line through variance against signal, per channel.

    Differences of frames give the variance where there are two; else a high-pass that lets no plane through
    (Immerkaer 1996, "Fast noise variance estimation", CVIU 64(2)), by its median, so that edges count little.
    Expected values, where there are some, keep edges and mosaics from being taken for noise.
    """
    real_dn, expected_dn, valid = capture.real_dn, capture.expected_dn, capture.valid
    context, mosaic = capture.context, capture.context.cfa is not None
    black_level_dn = context.black_level_dn
    static = len(real_dn) > 1 and (expected_dn is None or len(expected_dn) == 1)
    if static:  # pixels by themselves tell it, and some of many do
        real_dn, valid = thinned(real_dn), thinned(valid[..., None])[..., 0]
        expected_dn = None if expected_dn is None else thinned(expected_dn)
    level = real_dn.mean(axis=0)
    detail = real_dn[0] if expected_dn is None else real_dn[0] - expected_dn[0]
    white = 0.95 * context.white_level_dn
    clipped = (level >= white) | (level <= 0) | ~valid[..., None]
    if expected_dn is not None:
        clipped |= expected_dn.mean(axis=0) >= white
    if static:
        variance = _variance_of_pixels(real_dn, level, ~clipped)
    else:
        variance = _high_pass_variance(detail, 2 if mosaic else 1)
        clipped = _near(clipped, 2 if mosaic else 1)
        real_dn, valid = thinned(real_dn), thinned(valid[..., None])[..., 0]
        level, variance, clipped = (thinned(each) for each in (level, variance, clipped))
    photon, thermal = [], []
    for channel in range(real_dn.shape[-1]):
        plane = real_dn[..., channel][:, valid]
        if black_level_dn < 1 and plane.size and np.mean(plane == 0) > _CENSORED:
            photon.append(0.0)
            thermal.append(_censored_variance(plane))
            continue
        inside = ~clipped[..., channel]
        signal = level[..., channel][inside] - black_level_dn
        slope, intercept = _line(signal, variance[..., channel][inside], robust=not static)
        if static and signal.size and are_whole(plane):
            level_dn = float(signal.mean()) + black_level_dn if not slope else 0.0
            intercept = max(before_rounding(intercept, level_dn).variance_dn2, _LEAST_DN2)
        photon.append(slope)
        thermal.append(intercept)
    return Noise(tuple(photon), tuple(thermal), known=False)


def thinned(images: NDArray[Any]) -> NDArray[Any]:
    """(..., H, W, C) images as they are; of large ones (..., 1, P, C) every so many of their pixels.

    By an odd step, so that every colour of a mosaic is among them.
    """
    height, width, channels = images.shape[-3:]
    if height * width <= ENOUGH_PIXELS:
        return images
    step = height * width // ENOUGH_PIXELS | 1
    while width % step == 0:  # else it stays within some columns
        step += 2
    return images.reshape(*images.shape[:-3], 1, height * width, channels)[..., ::step, :]


def without_lines(noise: NDArray[np.floating], inside: NDArray[np.bool_]) -> NDArray[np.float64]:
    """(H, W) the noise of pixels by themselves, scaled by the degrees of freedom that means of lines take.

    Offsets that the pixels of a row or a column share in one frame are taken away line by line. Rows that
    jump, and a lamp that flickers, are no noise of pixels, and are found as what they are. What moves there
    counts for no mean.

    `noise`, `inside`: (H, W) noise of a frame, and the pixels that count.
    """
    left = np.asarray(noise, np.float64)
    if not inside.any():
        return left
    off = np.abs(left - np.median(left[inside]))
    still = inside & (off <= _STILL * max(_MEDIAN_TO_SPREAD * float(np.median(off[inside])), 1.0))
    pixels = int(np.count_nonzero(inside))
    lines = 0
    for axis in (1, 0):
        count = still.sum(axis=axis, keepdims=True)
        means = np.where(still, left, 0.0).sum(axis=axis, keepdims=True) / np.maximum(count, 1)
        left = left - np.where(count >= _FEWEST_IN_LINE, means, 0.0)
        lines += int(np.count_nonzero(count >= _FEWEST_IN_LINE))
    return left * (pixels / max(pixels - lines, 1)) ** 0.5


def _variance_of_pixels(
    real_dn: NDArray[np.float32], level: NDArray[np.float32], inside: NDArray[np.bool_]
) -> NDArray[np.float32]:
    """(H, W, C) variance over (N, H, W, C) frames of what pixels by themselves add to their mean [DN^2]."""
    total = np.zeros(level.shape)
    for frame in real_dn:
        for channel in range(level.shape[-1]):
            noise = frame[..., channel] - level[..., channel]
            total[..., channel] += without_lines(noise, inside[..., channel]) ** 2
    return np.asarray(total / (len(real_dn) - 1), np.float32)


def _censored_variance(samples: NDArray[np.float32]) -> float:
    """Variance of noise around 0 of which rounding and clipping left few values above 0.

    What is above a few digital numbers is a hot pixel, not noise.
    """
    share = float(np.mean((samples > 0) & (samples <= _NOISE_DN)))
    above_half = float(np.clip(share, 1e-6, 0.45))
    return float((0.5 / ndtri(1 - above_half)) ** 2)


def _line(signal: NDArray[np.float32], variance: NDArray[np.float32], robust: bool) -> tuple[float, float]:
    if signal.size < 100:
        return 0.0, 1.0
    edges = np.quantile(signal, np.linspace(0, 1, BINS + 1))
    which = np.clip(np.searchsorted(edges, signal, side="right") - 1, 0, BINS - 1)
    filled = [b for b in range(BINS) if (which == b).sum() >= 20]
    x = np.array([signal[which == b].mean() for b in filled])
    # the median of a squared Gaussian is 0.455 of its mean
    middle = (lambda v: np.median(v) / 0.455) if robust else np.mean
    y = np.array([middle(variance[which == b]) for b in filled])
    if len(x) < 2 or np.ptp(x) < 5:
        return 0.0, float(max(middle(variance), 0.01))
    weight = 1 / np.maximum(y, 0.01)
    line = np.stack([x, np.ones_like(x)], axis=1) * weight[:, None]
    (slope, intercept), *_ = np.linalg.lstsq(line, y * weight, rcond=None)
    slope = max(float(slope), 0.0)
    return slope, float(max(intercept if slope else y.mean(), 0.01))


def _near(pixels: NDArray[np.bool_], reach: int) -> NDArray[np.bool_]:
    """(H, W, C) pixels, and those whose high-pass they enter."""
    import cv2

    size = 2 * reach + 1
    grown = cv2.dilate(pixels.astype(np.uint8), np.ones((size, size), np.uint8))
    return np.asarray(grown.reshape(pixels.shape), bool)


def _high_pass_variance(frame: NDArray[np.float32], step: int) -> NDArray[np.float32]:
    """(H, W, C) squared high-pass over neighbours `step` pixels away [DN^2]."""
    import cv2

    kernel = np.zeros((2 * step + 1, 2 * step + 1), np.float32)
    kernel[::step, ::step] = [[1, -2, 1], [-2, 4, -2], [1, -2, 1]]
    filtered = cv2.filter2D(frame, cv2.CV_32F, kernel, borderType=cv2.BORDER_REFLECT)
    return np.asarray(filtered.reshape(frame.shape) ** 2 / _LAPLACIAN_GAIN, np.float32)
