"""Waves over the rows of a picture, beside what lens and lamp do along them."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

SHADING_DEGREE = 4
"""Degree of what lens and lamp do along the rows of a wall, which is no wave."""

_TOLD_APART = 0.05
"""Share of a wave's squares that shading must leave, about: of less, its amplitude counts in part."""


def amplitudes(
    profiles: NDArray[np.float64], periods: Sequence[float], degree: int = 0
) -> NDArray[np.float64]:
    """Amplitudes of waves in profiles, each fitted beside a polynomial by least squares.

    Rows fade out towards both ends, so that a wave of no whole number of periods looks alike at every phase.

    - `profiles`: (N, H) values of rows.
    - `periods`: K of them [row].
    - `degree`: that of the polynomial; 0 takes the mean away.

    Returns: (N, K) amplitudes, in the unit of the profiles.

    >>> rows = np.arange(200)
    >>> profile = 1 + 0.3 * np.sin(2 * np.pi * rows / 31.0 + 0.7)
    >>> amplitudes(profile[None], [31.0, 12.0]).round(1).tolist()
    [[0.3, 0.0]]
    """
    return np.asarray(np.abs(profiles @ _fits(profiles.shape[1], tuple(periods), degree).T))


@lru_cache(maxsize=32)
def _fits(height: int, periods: tuple[float, ...], degree: int) -> NDArray[np.complex128]:
    """(K, H) what takes a profile to the complex amplitudes of its waves."""
    fading = np.sqrt(np.hanning(height + 2)[1:-1])
    place = np.linspace(-1, 1, height)
    shading = np.polynomial.legendre.legvander(place, min(degree, height - 1)) * fading[:, None]
    shading, _ = np.linalg.qr(shading)
    angle = 2 * np.pi * np.arange(height) / np.array(periods)[:, None]
    waves = np.stack([np.cos(angle), np.sin(angle)], axis=1) * fading
    left = waves - waves @ shading @ shading.T
    normal = left @ left.transpose(0, 2, 1) + _TOLD_APART * float(np.sum(fading**2)) / 2 * np.eye(2)
    parts = np.linalg.solve(normal, left) * fading
    return np.asarray(parts[:, 0] - 1j * parts[:, 1])
