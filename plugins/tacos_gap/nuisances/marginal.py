"""Residuals with the nuisances integrated out.

Near a point nu0 residuals are z(nu) = z(nu0) - D (nu - nu0), nu ~ N(0, 1) in units of the priors. With the
nuisances integrated out, z(nu0) + D nu0 ~ N(0, I + D D'). Whitened by the inverse root of this covariance,
its sum of squares is the least of |z(nu)|^2 + |nu|^2: what lies within the priors costs next to nothing, and
what lies far outside of them stays in the score.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

ITERATIONS = 8
_ROBUST_SCALE = 10.0  # beyond it a residual weighs less, as in `problem.robust`


@dataclass(frozen=True, eq=False)
class Marginal:
    """The freedom of a capture's nuisances."""

    directions: NDArray[np.float64]
    """(K, F) change of the simulated numbers per standard deviation of each nuisance [noise floor]."""
    nu: NDArray[np.float64]  # (F,) where the expectation stands [standard deviations]

    def whitened(
        self, z: NDArray[np.float64], scale: NDArray[np.float64] | float = 1.0
    ) -> NDArray[np.float64]:
        """(..., K) residuals with unit variance, the nuisances included.

        `scale`: (K,) their noise floor over that of `directions`.
        """
        if not self.nu.size:
            return z
        directions = self.directions / np.broadcast_to(np.reshape(scale, (-1, 1)), self.directions.shape)
        z = z + directions @ self.nu
        u, sizes, _ = np.linalg.svd(directions, full_matrices=False)
        return np.asarray(z - (z @ u * (1 - 1 / np.sqrt(1 + sizes**2))) @ u.T)

    def spread(
        self,
        z: NDArray[np.float64],
        nuisances: NDArray[np.float64],
        scale: NDArray[np.float64] | float = 1.0,
    ) -> NDArray[np.float64]:
        """(B, K) whitened replicates of a simulator whose nuisances are drawn from the priors.

        - `z`: (B, K) replicates around the mean of the simulator.
        - `nuisances`: (B, F) drawn nuisances [standard deviations].
        - `scale`: as of `whitened`.
        """
        if not self.nu.size:
            return z
        around = Marginal(self.directions, np.zeros_like(self.nu))
        moved = nuisances @ self.directions.T / np.broadcast_to(scale, z.shape[-1:])
        return around.whitened(z + moved, scale)

    def most_likely(self, z: NDArray[np.float64]) -> NDArray[np.float64]:
        """(F,) nuisances that (K,) residuals at `nu` ask for, prior included; wild residuals weigh less."""
        nu = np.asarray(self.nu, np.float64)
        linear = z + self.directions @ self.nu
        for _ in range(ITERATIONS):
            left = linear - self.directions @ nu
            weighted = self.directions / (1 + (left / _ROBUST_SCALE) ** 2)[:, None]
            normal = weighted.T @ self.directions + np.eye(len(nu))
            nu = np.asarray(np.linalg.solve(normal, weighted.T @ linear), np.float64)
        return np.asarray(nu)
