"""Radius of the disc that has blurred a picture, from its spectrum and that of what is expected."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

from tacos_framework import ObservedCapture
from tacos_plugins.effects.blur import disc_transfer

RADII_PX = np.geomspace(0.3, 20.0, 55)
"""Radii that are looked at [px]."""

BLURRED, SHARP = 0.5, 0.9
"""Share of the squares without a disc that the best one leaves: below the first there is one, above the
second none."""

_RINGS = 40  # bands of frequency
_LARGEST = 8  # of the shorter side, over the largest radius that it can show
_ROUNDS = 4


@dataclass(frozen=True)
class DiscFit:
    """The disc that explains a spectrum best, and the share of squares that it leaves of those without."""

    radius_px: float
    left: float


def disc_of(capture: ObservedCapture) -> DiscFit | None:
    """The disc with which the expectation has the spectrum of the mean frame, up to gain and white noise.

    None where nothing is expected.
    """
    if capture.expected_dn is None or not capture.valid.any():
        return None
    real, expected = (
        power_spectrum(mean_image(each), capture.valid) for each in (capture.real_dn, capture.expected_dn)
    )
    return disc_fits([(real, expected)])[0]


def mean_image(frames: NDArray[np.float32]) -> NDArray[np.float64]:
    """(H, W) the mean of (N, H, W, C) frames and their colours [DN]."""
    return np.asarray(frames.mean(axis=(0, 3), dtype=np.float64))


def disc_fits(pairs: Sequence[tuple[NDArray[np.float64], NDArray[np.float64]]]) -> list[DiscFit | None]:
    """The best disc of each pair of power spectra, real and expected, all of one shape (H, W).

    None where nothing is expected, or the real one is empty.
    """
    shape = pairs[0][0].shape
    fx, fy = (np.fft.fftfreq(size).astype(np.float64) for size in shape[::-1])
    rings = (np.hypot(fx[None, :], fy[:, None]) / 0.5 * _RINGS).astype(np.int64)
    inside = (rings < _RINGS) & (np.hypot(fx[None, :], fy[:, None]) > 2 / min(shape))
    weights = np.bincount(rings[inside], minlength=_RINGS)
    kept = weights > 0

    def of_rings(power: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(np.bincount(rings[inside], power[inside], _RINGS)[kept] / weights[kept])

    seen = [of_rings(real) for real, _ in pairs]
    usable = [
        bool(power.all() and expected[inside].any()) for power, (_, expected) in zip(seen, pairs, strict=True)
    ]
    radii = RADII_PX[min(shape) / _LARGEST > RADII_PX]
    costs = np.full((len(pairs), 1 + len(radii)), np.inf)
    for k, radius in enumerate((0.0, *radii)):
        passed = _passed_by_disc(radius, fx, fy)
        for i, (_, expected) in enumerate(pairs):
            if usable[i]:
                costs[i, k] = _unexplained(seen[i], of_rings(passed * expected), weights[kept])
    best = costs[:, 1:].argmin(axis=1) if len(radii) else None
    return [
        DiscFit(float(radii[best[i]]), float(cost[1 + best[i]] / max(cost[0], 1e-300)))
        if best is not None and usable[i]
        else None
        for i, cost in enumerate(costs)
    ]


def _passed_by_disc(
    radius_px: float, fx: NDArray[np.float64], fy: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(H, W) share of power that a disc lets pass at (W,) and (H,) frequencies of an FFT [1]."""
    above = [np.abs(frequencies[: len(frequencies) // 2 + 1]) for frequencies in (fx, fy)]
    columns, rows = (np.minimum(n := np.arange(len(each)), len(each) - n) for each in (fx, fy))
    quarter = disc_transfer(radius_px)(above[0][None, :], above[1][:, None]) ** 2
    return quarter[np.ix_(rows, columns)]


def power_spectrum(image: NDArray[np.float64], valid: NDArray[np.bool_]) -> NDArray[np.float64]:
    """(H, W) power of an image without its mean, and faded out towards the borders."""
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
