"""Periodic noise, made in the frequency domain so that it tiles by construction."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray


def fractal(
    rng: np.random.Generator,
    size: int,
    *,
    exponent: float = 1.0,
    stretch: tuple[float, float] = (1.0, 1.0),
    lowest: float = 1.0,
    highest: float | None = None,
) -> NDArray[np.float64]:
    """(size, size) Gaussian noise of mean 0 and standard deviation 1 with amplitude 1 / frequency^exponent.

    - `exponent`: 0 is white, 1 is pink (equal contrast at every scale), 2 is cloud-like.
    - `stretch`: how much longer features are along (u, v) than across.
    - `lowest`, `highest`: band outside of which there is nothing [cycles per tile].
    """
    from scipy import fft  # late: checking a recipe draws nothing

    amplitude = _amplitude(size, exponent, stretch, lowest, highest)
    # Transforms of scipy give the bits of numpy's and take a third of the time along columns.
    spectrum = fft.rfft2(rng.standard_normal((size, size)))
    spectrum[: len(amplitude)] *= amplitude
    spectrum[len(amplitude) :] *= amplitude[(size - 1) // 2 : 0 : -1]
    noise = np.fft.irfft(fft.ifft(spectrum, axis=0, overwrite_x=True), size, axis=1)
    noise /= max(float(noise.std()), 1e-12)
    return np.asarray(noise)


@lru_cache(maxsize=96)
def _amplitude(
    size: int, exponent: float, stretch: tuple[float, float], lowest: float, highest: float | None
) -> NDArray[np.float64]:
    """(size // 2 + 1, size // 2 + 1) amplitude at frequencies from 0 along v and along u; see `fractal`."""
    u = np.fft.rfftfreq(size, 1 / size)[None, :] * stretch[0]
    v = np.fft.rfftfreq(size, 1 / size)[:, None] * stretch[1]
    frequency = np.hypot(u, v)
    amplitude = np.where(frequency >= lowest, np.maximum(frequency, 1e-9) ** -(exponent + 0.0), 0.0)
    if highest is not None:
        amplitude = amplitude * np.exp(-((frequency / highest) ** 4))
    return np.asarray(amplitude)


def smoothstep(value: NDArray[np.float64], low: float, high: float) -> NDArray[np.float64]:
    """0 below `low`, 1 above `high`, smooth between."""
    t = np.clip((value - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)
