"""Covariance of the scores of cameras: what they have in common along each coordinate, and by scene."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

NO_EPISODE = -1
"""The number of an episode that is none: an observation of which no scene is known."""

MISSING = 0.25
"""Squared distance, in ranges of a coordinate, between a point that does not tell it and one that does.

Half of the range: a value that may lie anywhere is that far from a known one, about.
"""

DRIFT_LENGTH = 0.5
"""Length scale of what changes with time for all points alike, in the time observed so far."""


@dataclass(frozen=True)
class Hyperparameters:
    """Standard deviations of the parts of a score, and the length scales along its coordinates.

    All but the length scales are in standard deviations of the observed values.
    """

    length_scales: tuple[float, ...]
    """One for each coordinate [ranges of the coordinate]."""
    signal: float = 1.0
    """Variation of points, whatever the scene [standard deviations]."""
    episode: float = 0.2
    """Effect of a scene on all points alike."""
    interaction: float = 0.2
    """Effect of a scene on a point, and similarly on points near it."""
    noise: float = 0.1
    """Scatter of repeated observations."""
    drift: float = 0.0
    """Effect of time on all points alike."""
    counting: float = 0.0
    """Scatter because few are counted; known beforehand, and no part of the mean score."""

    @property
    def within_episodes(self) -> float:
        """Variance of what one observation would be of, were many counted, about the mean over all scenes."""
        return self.episode**2 + self.interaction**2 + self.noise**2

    @property
    def of_itself(self) -> float:
        """Variance that each observation has for itself alone."""
        return self.noise**2 + self.counting**2


def matern(squared: Array) -> Array:
    """Correlation of the Matern family with smoothness 5/2.

    `squared`: squared distances, in length scales.

    Source: Rasmussen and Williams 2006, "Gaussian processes for machine learning", eq. (4.17).
    """
    r = np.sqrt(5 * squared)
    return np.asarray((1 + r + r * r / 3) * np.exp(-r))


def matern_slope(squared: Array) -> Array:
    """Minus twice the derivative of :func:`matern` by the squared distance."""
    r = np.sqrt(5 * squared)
    return np.asarray(5 / 3 * (1 + r) * np.exp(-r))


def squared_differences(first: Array, second: Array) -> Array:
    """(d, n, m) squared differences of (n, d) and (m, d) points along each coordinate; NaN is not known."""
    a, b = np.nan_to_num(first, nan=0.5), np.nan_to_num(second, nan=0.5)
    squared = (a.T[:, :, None] - b.T[:, None, :]) ** 2
    if np.isnan(first).any() or np.isnan(second).any():
        missing = np.isnan(first).T[:, :, None] != np.isnan(second).T[:, None, :]
        squared += MISSING * missing
    return np.asarray(squared)


def scaled_distances(first: Array, second: Array, length_scales: Array) -> Array:
    """(n, m) squared distances in length scales; as the sum of :func:`squared_differences`, but quicker."""
    a = np.nan_to_num(first, nan=0.5) / length_scales
    b = np.nan_to_num(second, nan=0.5) / length_scales
    squared = (a * a).sum(axis=1)[:, None] + (b * b).sum(axis=1)[None, :] - 2 * a @ b.T
    missing, missing_too = np.isnan(first), np.isnan(second)
    if missing.any() or missing_too.any():
        weights = MISSING / length_scales**2
        known = (~missing).astype(float)
        squared += (missing * weights) @ (~missing_too).T + (known * weights) @ missing_too.T
    return np.maximum(squared, 0.0)


def same_episode(first: NDArray[np.int64], second: NDArray[np.int64]) -> Array:
    """(n, m) 1.0 where both are of one scene."""
    return np.asarray((first[:, None] == second[None, :]) & (first[:, None] != NO_EPISODE), dtype=np.float64)


def drifted(first: Array, second: Array) -> Array:
    """(n, m) correlation over time of two rows of times, in the time observed so far."""
    return matern(((first[:, None] - second[None, :]) / DRIFT_LENGTH) ** 2)
