"""Hyperparameters that explain observations best: marginal likelihood, with weak priors."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tacos_plugins.surrogate.gaussian_process import MEAN_VARIANCE, Inputs, factorised
from tacos_plugins.surrogate.kernel import (
    NO_EPISODE,
    Hyperparameters,
    drifted,
    matern,
    matern_slope,
    same_episode,
    squared_differences,
)

Array = NDArray[np.float64]

LENGTH_SCALE = (0.5, 1.0)
"""Median, for one coordinate, and standard deviation of the logarithm, of a length scale.

The median grows with the root of the number of coordinates, as the distance between points does (Hvarfner et
al. 2024, "Vanilla Bayesian optimization performs great in high dimensions").
"""

AMPLITUDES = {
    "signal": (1.0, 1.0),
    "episode": (0.3, 1.0),
    "interaction": (0.2, 1.0),
    "noise": (0.1, 1.5),
    "drift": (0.3, 1.0),
}
"""Median and standard deviation of the logarithm of each standard deviation, in that of the observed values.

Wide enough that some twenty observations outweigh them, and narrow enough that eight give no nonsense.
"""

SMALLEST, LARGEST = 1e-3, 1e3
"""Bounds of all hyperparameters; noise of 0.001 keeps covariances well conditioned."""


@dataclass(frozen=True, eq=False)
class Evidence:
    """The log posterior density of hyperparameters, up to a constant, and its gradient."""

    inputs: Inputs
    values: Array
    """As those of `GaussianProcess`."""
    counting: float = 0.0
    """Standard deviation of the noise that is known beforehand."""

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The standard deviations that the observations tell of."""
        scenes = ("episode", "interaction") if (self.inputs.episodes != NO_EPISODE).any() else ()
        drift = ("drift",) if self.inputs.times is not None else ()
        return ("signal", *scenes, "noise", *drift)

    @property
    def dimension(self) -> int:
        return self.inputs.points.shape[1]

    @cached_property
    def prior(self) -> tuple[Array, Array]:
        """Mean and standard deviation of the logarithm of each hyperparameter, length scales first."""
        median, spread = LENGTH_SCALE
        lengths = [(median * math.sqrt(max(self.dimension, 1)), spread)] * self.dimension
        medians, spreads = np.array([*lengths, *(AMPLITUDES[name] for name in self.names)]).T
        return np.log(medians), spreads

    @cached_property
    def _squared(self) -> Array:
        n = len(self.inputs)
        return squared_differences(self.inputs.points, self.inputs.points).reshape(self.dimension, n * n)

    @cached_property
    def _common(self) -> Array:
        return same_episode(self.inputs.episodes, self.inputs.episodes)

    @cached_property
    def _drifted(self) -> Array | None:
        times = self.inputs.times
        return None if times is None else drifted(times, times)

    def logarithms(self, h: Hyperparameters) -> Array:
        """The hyperparameters as a vector of logarithms, within bounds."""
        values = np.array([*h.length_scales, *(getattr(h, name) for name in self.names)])
        return np.log(np.clip(values, SMALLEST, LARGEST))

    def hyperparameters(self, logarithms: Array) -> Hyperparameters:
        """Undoes :meth:`logarithms`; what the observations do not tell of is zero."""
        values = np.exp(logarithms).tolist()
        amplitudes = dict.fromkeys(AMPLITUDES, 0.0) | dict(
            zip(self.names, values[self.dimension :], strict=True)
        )
        return Hyperparameters(tuple(values[: self.dimension]), **amplitudes, counting=self.counting)

    def loss(self, logarithms: Array) -> tuple[float, Array]:
        """Minus the log posterior density, and its gradient by the logarithms.

        Source: Rasmussen and Williams 2006, eq. (5.8) and (5.9).
        """
        from scipy.linalg.lapack import dpotri  # late: checking a recipe fits nothing

        n, d = len(self.inputs), self.dimension
        h = self.hyperparameters(logarithms)
        inverse_squares = np.exp(-2 * logarithms[:d])
        squared = (inverse_squares @ self._squared).reshape(n, n)
        correlation = matern(squared)
        within = h.interaction**2 * self._common
        total = correlation * (h.signal**2 + within) + h.episode**2 * self._common + MEAN_VARIANCE
        if self._drifted is not None:
            total += h.drift**2 * self._drifted
        total[np.diag_indices(n)] += h.of_itself

        factor = factorised(total)
        inverse = np.tril(dpotri(factor, lower=1)[0])
        inverse += np.tril(inverse, -1).T
        weights = inverse @ self.values
        slope = np.outer(weights, weights) - inverse  # twice the derivative by the covariance
        by_distance = slope * (h.signal**2 + within) * matern_slope(squared)
        gradient = np.empty_like(logarithms)
        gradient[:d] = -0.5 * inverse_squares * (self._squared @ by_distance.ravel())
        parts = {
            "signal": correlation,
            "episode": self._common,
            "interaction": correlation * self._common,
            "noise": np.eye(n),
            "drift": self._drifted,
        }
        for i, name in enumerate(self.names):
            gradient[d + i] = -(getattr(h, name) ** 2) * float(np.vdot(slope, parts[name]))

        mean, spread = self.prior
        deviations = (logarithms - mean) / spread
        loss = 0.5 * float(self.values @ weights) + float(np.log(np.diag(factor)).sum())
        return loss + 0.5 * float(deviations @ deviations), gradient + deviations / spread


def fit_hyperparameters(
    inputs: Inputs,
    values: Array,
    *,
    counting: float = 0.0,
    start: Hyperparameters | None = None,
    most_steps: int = 40,
) -> Hyperparameters:
    """The most probable hyperparameters, found by L-BFGS.

    - `inputs`, `values`: as those of `GaussianProcess`.
    - `counting`: standard deviation of the noise that is known beforehand.
    - `start`: where to begin, such as what was found for fewer observations; by default the middle of the
      priors.
    """
    from scipy.optimize import minimize  # late: checking a recipe fits nothing

    evidence = Evidence(inputs, values, counting)
    middle, _ = evidence.prior
    begin = middle if start is None else evidence.logarithms(start)
    bounds = [(math.log(SMALLEST), math.log(LARGEST))] * len(middle)
    found = minimize(
        evidence.loss, begin, jac=True, method="L-BFGS-B", bounds=bounds, options={"maxiter": most_steps}
    )
    return evidence.hyperparameters(found.x)
