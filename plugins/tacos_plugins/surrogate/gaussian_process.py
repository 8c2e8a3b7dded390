"""An exact Gaussian process of one score, with scenes as random effects."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tacos_plugins.surrogate.kernel import Hyperparameters, drifted, matern, same_episode, scaled_distances

Array = NDArray[np.float64]

MEAN_VARIANCE = 1.0
"""Variance of the unknown mean of all, in variances of the observed values, which have been centred."""

JITTERS = (0.0, 1e-10, 1e-8, 1e-6, 1e-4)
"""Additions to the diagonal, in variances of the signal, until a factorisation succeeds."""


@dataclass(frozen=True, eq=False)
class Inputs:
    """Places of observations."""

    points: Array
    """(n, d) coordinates, each scaled to about 0..1; NaN where one is not known."""
    episodes: NDArray[np.int64]
    """(n,) number of the scene, or `NO_EPISODE`."""
    times: Array | None = None
    """(n,) when, of what drifts; None where nothing does."""

    def __len__(self) -> int:
        return len(self.points)

    def take(self, rows: NDArray[np.int64]) -> Inputs:
        times = None if self.times is None else self.times[rows]
        return Inputs(self.points[rows], self.episodes[rows], times)


@dataclass(frozen=True, eq=False)
class GaussianProcess:
    """Values at points, of which noisy observations in scenes are known.

    An observation in scene e is ``m + f(x) + s_e + g_e(x) + drift(t) + noise``; f and each g_e vary smoothly
    along the coordinates. What is predicted is ``m + f(x) + drift(latest)``: the value in a scene like those
    observed, on average.

    Source: Rasmussen and Williams 2006, "Gaussian processes for machine learning", algorithm 2.1.
    """

    inputs: Inputs
    """Places of observations."""
    values: Array
    """(n,) what was observed, centred and of unit variance."""
    hyperparameters: Hyperparameters
    """As :func:`tacos_plugins.surrogate.evidence.fit_hyperparameters` finds them."""

    @cached_property
    def _length_scales(self) -> Array:
        return np.array(self.hyperparameters.length_scales, dtype=np.float64)

    @cached_property
    def _factor(self) -> Array:
        return factorised(covariance(self.inputs, self.hyperparameters))

    @cached_property
    def _weights(self) -> Array:
        from scipy.linalg import cho_solve  # late: checking a recipe predicts nothing

        return np.asarray(cho_solve((self._factor, True), self.values, check_finite=False))

    @property
    def _latest(self) -> float:
        return 0.0 if self.inputs.times is None else float(self.inputs.times.max())

    def at(self, points: Array) -> Prediction:
        """Prediction at (m, d) points."""
        from scipy.linalg import solve_triangular  # late: as above

        h = self.hyperparameters
        squared = scaled_distances(self.inputs.points, points, self._length_scales)
        across = h.signal**2 * matern(squared) + MEAN_VARIANCE
        if self.inputs.times is not None:
            across += h.drift**2 * drifted(self.inputs.times, np.array([self._latest]))
        explained = solve_triangular(self._factor, across, lower=True, check_finite=False)
        return Prediction(self, points, across.T @ self._weights, np.asarray(explained))

    def prior(self, first: Array, second: Array) -> Array:
        """(n, m) covariance of (n, d) and (m, d) points before anything is observed."""
        h = self.hyperparameters
        common = MEAN_VARIANCE + (h.drift**2 if self.inputs.times is not None else 0.0)
        return h.signal**2 * matern(scaled_distances(first, second, self._length_scales)) + common


@dataclass(frozen=True, eq=False)
class Prediction:
    """Posterior of the values at points."""

    process: GaussianProcess
    points: Array
    mean: Array
    explained: Array
    """(n, m) square root of what observations take from the covariance."""

    @cached_property
    def sd(self) -> Array:
        """(m,) standard deviations."""
        before = float(self.process.prior(self.points[:1], self.points[:1]).sum())
        return np.sqrt(np.maximum(before - np.einsum("ij,ij->j", self.explained, self.explained), 0.0))

    @cached_property
    def covariance(self) -> Array:
        """(m, m) covariance of the points."""
        return self.process.prior(self.points, self.points) - self.explained.T @ self.explained

    def having_seen(self, index: int) -> Prediction:
        """Prediction once the point of this number is observed in a new scene, at its mean."""
        prior = self.process.prior(self.points, self.points[index : index + 1])[:, 0]
        covariances = prior - self.explained.T @ self.explained[:, index]
        h = self.process.hyperparameters
        variance = max(float(covariances[index]), 0.0) + h.within_episodes + h.counting**2
        more = np.vstack([self.explained, covariances / np.sqrt(variance)])
        return Prediction(self.process, self.points, self.mean, more)


def covariance(inputs: Inputs, h: Hyperparameters) -> Array:
    """(n, n) covariance of observations."""
    scales = np.array(h.length_scales, dtype=np.float64)
    common = same_episode(inputs.episodes, inputs.episodes)
    correlation = matern(scaled_distances(inputs.points, inputs.points, scales))
    total = correlation * (h.signal**2 + h.interaction**2 * common) + h.episode**2 * common + MEAN_VARIANCE
    if inputs.times is not None:
        total += h.drift**2 * drifted(inputs.times, inputs.times)
    total[np.diag_indices_from(total)] += h.of_itself
    return np.asarray(total)


def factorised(matrix: Array) -> Array:
    """The lower Cholesky factor, of the matrix or of one with the least more on its diagonal that has one.

    Raises `numpy.linalg.LinAlgError` when not even a ten-thousandth of the mean of the diagonal suffices: it
    is no covariance.
    """
    scale = float(np.trace(matrix)) / max(len(matrix), 1)
    for jitter in JITTERS:
        try:
            return np.asarray(
                np.linalg.cholesky(matrix + jitter * scale * np.eye(len(matrix))), dtype=np.float64
            )
        except np.linalg.LinAlgError:
            continue
    raise np.linalg.LinAlgError(f"a matrix of {len(matrix)} rows is no covariance: {matrix!r}")
