"""Radius of the disc that has blurred a picture, from its spectrum and that of what is expected."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

from tacos_framework import ObservedCapture
from tacos_plugins.effects.blur import disc_transfer

RADII_PX = np.geomspace(0.3, 20.0, 55)
"""Radii that are looked at [px]."""

LEAST_SHARE = 0.5
"""Squares that the best disc may leave of that without any, where there is one."""

_RINGS = 40  # bands of frequency
_LARGEST = 8  # of the shorter side, over the largest radius that it can show
_ROUNDS = 4


def disc_radius_px(capture: ObservedCapture) -> float | None:
    """The radius with which the expectation has the spectrum of the mean frame, up to gain and white noise.

    Returns: [px]; None where no disc explains the spectrum much better than gain and noise alone.
    """
    if capture.expected_dn is None or not capture.valid.any():
        return None
    real, expected = (_power(frames, capture.valid) for frames in (capture.real_dn, capture.expected_dn))
    fx, fy = (np.fft.fftfreq(size).astype(np.float64) for size in real.shape[::-1])
    rings = (np.hypot(fx[None, :], fy[:, None]) / 0.5 * _RINGS).astype(np.int64)
    inside = (rings < _RINGS) & (np.hypot(fx[None, :], fy[:, None]) > 2 / min(real.shape))
    weights = np.bincount(rings[inside], minlength=_RINGS)
    kept = weights > 0
    seen = np.bincount(rings[inside], real[inside], _RINGS)[kept] / weights[kept]
    if not expected[inside].any() or not seen.all():
        return None

    def left(radius_px: float) -> float:
        passed = _passed_by_disc(radius_px, fx, fy) * expected
        shown = np.bincount(rings[inside], passed[inside], _RINGS)[kept] / weights[kept]
        return _unexplained(seen, shown, weights[kept])

    radii = RADII_PX[min(real.shape) / _LARGEST > RADII_PX]
    if not len(radii):
        return None
    cost = np.array([left(radius) for radius in radii])
    best = int(np.argmin(cost))
    return float(radii[best]) if best and cost[best] < LEAST_SHARE * left(0.0) else None


def _passed_by_disc(
    radius_px: float, fx: NDArray[np.float64], fy: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(H, W) share of power that a disc lets pass at (W,) and (H,) frequencies of an FFT [1]."""
    above = [np.abs(frequencies[: len(frequencies) // 2 + 1]) for frequencies in (fx, fy)]
    columns, rows = (np.minimum(n := np.arange(len(each)), len(each) - n) for each in (fx, fy))
    quarter = disc_transfer(radius_px)(above[0][None, :], above[1][:, None]) ** 2
    return quarter[np.ix_(rows, columns)]


def _power(frames: NDArray[np.float32], valid: NDArray[np.bool_]) -> NDArray[np.float64]:
    """(H, W) power spectrum of the mean frame, without its mean and faded out towards the borders."""
    image = frames.mean(axis=(0, 3), dtype=np.float64)
    height, width = image.shape
    faded = np.where(valid, image - image[valid].mean(), 0.0)
    return np.asarray(np.abs(np.fft.fft2(faded * np.hanning(height)[:, None] * np.hanning(width))) ** 2)


def _unexplained(seen: NDArray[np.float64], shown: NDArray[np.float64], weights: NDArray[np.int64]) -> float:
    """Squares of amplitudes that the best multiple of another spectrum and white noise leave.

    Amplitudes count as they are: what stands out of a picture weighs more than its faint fine grain, which
    codecs and interpolation colour.
    """
    columns = np.stack([shown, np.ones_like(shown)], axis=1)
    model = seen
    for _ in range(_ROUNDS):
        root = np.sqrt(weights / np.maximum(model, 1e-12 * seen.max()))
        shares, _ = nnls(columns * root[:, None], seen * root)
        model = np.maximum(columns @ shares, 1e-9 * seen)
    return float(np.sum(weights * (np.sqrt(seen) - np.sqrt(model)) ** 2))
