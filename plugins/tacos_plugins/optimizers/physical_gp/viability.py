"""Probability that a candidate can be evaluated, from those that failed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_plugins.surrogate.evidence import fit_hyperparameters
from tacos_plugins.surrogate.gaussian_process import GaussianProcess, Inputs
from tacos_plugins.surrogate.kernel import NO_EPISODE

Array = NDArray[np.float64]

MOST_STEPS = 15
"""Iterations of the fit; where the border lies shows after few."""


@dataclass(frozen=True, eq=False)
class Viability:
    """The probability that a candidate can be evaluated.

    A Gaussian process of +1 for what could be and -1 for what failed, fitted by least squares, is quick, and
    finds which coordinates the border depends on.

    Source: Rasmussen and Williams 2006, "Gaussian processes for machine learning", Sec. 6.5 (least-squares
    classification).
    """

    process: GaussianProcess | None
    """The model of the labels, centred and scaled; None where nothing failed, or all did."""
    border: float = 0.0
    """Zero, between the labels, centred and scaled alike."""
    always: float = 1.0
    """The probability where there is no model."""

    @classmethod
    def fit(cls, rows: Array, succeeded: NDArray[np.bool_]) -> Viability:
        """From (trials, names) scaled coordinates and whether each could be evaluated."""
        if not succeeded.any() or succeeded.all():
            return cls(None, always=1.0 if succeeded.all() else 0.5)
        labels = np.where(succeeded, 1.0, -1.0)
        values = (labels - labels.mean()) / labels.std()
        inputs = Inputs(rows, np.full(len(rows), NO_EPISODE))
        found = fit_hyperparameters(inputs, values, most_steps=MOST_STEPS)
        return cls(GaussianProcess(inputs, values, found), float(-labels.mean() / labels.std()))

    def chances(self, rows: Array) -> Array:
        """(points,) the probability at (points, names) scaled coordinates."""
        from scipy.special import ndtr  # late: checking a recipe predicts nothing

        if self.process is None:
            return np.full(len(rows), self.always)
        prediction = self.process.at(rows)
        spread = np.hypot(prediction.sd, self.process.hyperparameters.noise)
        return np.asarray(ndtr((prediction.mean - self.border) / spread))
