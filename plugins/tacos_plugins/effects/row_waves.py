"""Waves over the rows of a picture, beside what lens and lamp do along them."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

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


class CommonWave(NamedTuple):
    """The wave that profiles share but for its phase.

    - `period`: of the wave [row].
    - `amplitude`: right on average over phases, in the unit of the profiles.
    - `share`: of the squares of what differs between the profiles.
    """

    period: float
    amplitude: float
    share: float


def common_wave(groups: Sequence[NDArray[np.float64]], periods: Sequence[float]) -> CommonWave:
    """The strongest wave of one period in groups of profiles, each at a phase of its own.

    What the profiles of a group have in common may have any form: it is left out with their mean.

    - `groups`: (N, H) values of rows each; N is 2 or more, H alike.
    - `periods`: those among which it is looked for [row].
    """
    height = groups[0].shape[1]
    fading = np.sqrt(np.hanning(height + 2)[1:-1])
    angle = 2 * np.pi * np.arange(height) / np.array(periods)[:, None]
    waves = np.stack([np.ones_like(angle), np.cos(angle), np.sin(angle)], axis=-1) * fading[:, None]
    orthogonal, triangle = np.linalg.qr(waves)
    apart = [(profiles - profiles.mean(axis=0)) * fading for profiles in groups]
    level = fading / np.linalg.norm(fading)
    apart = [each - np.outer(each @ level, level) for each in apart]  # frames may be brighter as a whole
    parts = [(each @ orthogonal)[..., 1:] for each in apart]  # (K, N, 2)
    taken = np.sum([np.sum(part**2, axis=(1, 2)) for part in parts], axis=0)
    best = int(np.argmax(taken))
    squares = [
        np.sum(np.linalg.solve(triangle[best, 1:, 1:], part[best].T) ** 2) / (len(part[best]) - 1)
        for part in parts
    ]
    whole = sum(float(np.sum(each**2)) for each in apart)
    return CommonWave(periods[best], float(np.mean(squares)) ** 0.5, float(taken[best]) / max(whole, 1e-300))


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
