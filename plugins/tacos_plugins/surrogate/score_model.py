"""One score, modelled on a scale of its own."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_plugins.surrogate.evidence import fit_hyperparameters
from tacos_plugins.surrogate.gaussian_process import GaussianProcess, Inputs, Prediction
from tacos_plugins.surrogate.kernel import Hyperparameters
from tacos_plugins.surrogate.transforms import Transform

Array = NDArray[np.float64]

MOST_FOR_HYPERPARAMETERS = 300
"""Observations that hyperparameters are fitted to at most, evenly spread: more take seconds."""

MOST_OBSERVATIONS = 1500
"""Observations that predictions are made from at most; a factorisation of so many takes a quarter second."""


@dataclass(frozen=True, eq=False)
class ScoreModel:
    """A Gaussian process of a transformed score, centred and scaled."""

    process: GaussianProcess
    transform: Transform
    """From scores to the scale on which they are modelled."""
    centre: float
    scale: float
    """Mean and standard deviation that were taken out on that scale."""
    columns: NDArray[np.int64]
    """The coordinates it depends on, among those of a row."""

    @classmethod
    def fit(
        cls,
        inputs: Inputs,
        scores: Array,
        transform: Transform,
        *,
        columns: NDArray[np.int64],
        start: Hyperparameters | None = None,
        fixed: bool = False,
    ) -> ScoreModel:
        """A model of these scores, (n,) in their own unit; `start` and `fixed` as those of `GreyBox.fit`."""
        kept = _spread_with_latest(len(scores))
        inputs = inputs.take(kept)
        transformed = transform.forward(scores[kept])
        centre = float(transformed.mean())
        smallest = transform.smallest_spread * max(1.0, abs(centre))
        scale = max(float(transformed.std()), smallest)
        values = (transformed - centre) / scale
        if start is None or not fixed:
            some = _spread(len(values), MOST_FOR_HYPERPARAMETERS)
            counting = transform.counting_noise(scores) / scale
            start = fit_hyperparameters(inputs.take(some), values[some], counting=counting, start=start)
        return cls(GaussianProcess(inputs, values, start), transform, centre, scale, columns)

    def at(self, rows: Array) -> Prediction:
        """The values at (m, names) rows, centred and scaled."""
        return self.process.at(rows[:, self.columns])

    def scores(self, values: Array) -> Array:
        """The score, averaged over scenes and noise, for values of the process, in its own unit."""
        variance = self.process.hyperparameters.within_episodes * self.scale**2
        return self.transform.expected(self.centre + self.scale * values, variance)


def _spread(count: int, most: int) -> NDArray[np.int64]:
    """At most so many of the numbers up to `count`, evenly spread, the last one among them."""
    if count <= most:
        return np.arange(count)
    return np.unique(np.linspace(0, count - 1, most).round().astype(np.int64))


def _spread_with_latest(count: int) -> NDArray[np.int64]:
    """All numbers up to `count` or, where they are too many, the latest half and a spread of the others.

    A search ends where the fitness is high: the latest tell most of the best.
    """
    if count <= MOST_OBSERVATIONS:
        return np.arange(count)
    latest = np.arange(count - MOST_OBSERVATIONS // 2, count)
    return np.concatenate([_spread(int(latest[0]), MOST_OBSERVATIONS - len(latest)), latest])
