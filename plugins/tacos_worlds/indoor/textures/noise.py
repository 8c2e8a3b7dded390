"""Periodic noise, made in the frequency domain so that it tiles by construction."""

from __future__ import annotations

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

    Parameters
    ----------
    exponent
        0 is white, 1 is pink (equal contrast at every scale), 2 is cloud-like.
    stretch
        How much longer features are along (u, v) than across.
    lowest, highest
        Band outside of which there is nothing [cycles per tile].
    """
    u = np.fft.rfftfreq(size, 1 / size)[None, :] * stretch[0]
    v = np.fft.fftfreq(size, 1 / size)[:, None] * stretch[1]
    frequency = np.hypot(u, v)
    amplitude = np.where(frequency >= lowest, np.maximum(frequency, 1e-9) ** -(exponent + 0.0), 0.0)
    if highest is not None:
        amplitude = amplitude * np.exp(-((frequency / highest) ** 4))
    spectrum = np.fft.rfft2(rng.standard_normal((size, size))) * amplitude
    noise = np.fft.irfft2(spectrum, s=(size, size))
    return np.asarray(noise / max(float(noise.std()), 1e-12))


def warped(
    image: NDArray[np.float64], shift_u: NDArray[np.float64], shift_v: NDArray[np.float64]
) -> NDArray[np.float64]:
    """The periodic image sampled at shifted places (nearest texel); shifts in texels."""
    size = len(image)
    rows, columns = np.indices((size, size))
    return image[
        (rows + np.rint(shift_v).astype(int)) % size, (columns + np.rint(shift_u).astype(int)) % size
    ]


def smoothstep(value: NDArray[np.float64], low: float, high: float) -> NDArray[np.float64]:
    """0 below `low`, 1 above `high`, smooth between."""
    t = np.clip((value - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)
