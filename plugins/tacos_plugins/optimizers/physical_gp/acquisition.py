"""Value of evaluating candidates."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tacos_plugins.surrogate.fitness_posterior import FitnessPosterior, normal_rule

Array = NDArray[np.float64]

DRAWS = 64
"""Points of the quasi-random rule that expected improvements are taken over."""

OPTIMISM = 2.0
"""Standard deviations above the mean by which global candidates are ranked."""


def expected_improvement(posterior: FitnessPosterior, incumbent: float) -> Array:
    """(points,) by how much each is expected to exceed a fitness, where falling short of it costs nothing.

    A sum of scores on scales of their own is not Gaussian, so the mean is taken over draws.

    Sources: Mockus et al. 1978, "The application of Bayesian methods for seeking the extremum"; Balandat et
    al. 2020, "BoTorch" (by draws, the same ones for all points).
    """
    draws = posterior.marginal_draws(normal_rule(DRAWS, len(posterior.models)))
    return np.asarray(np.maximum(draws - incumbent, 0.0).mean(axis=0))


def chosen_in_turn(posterior: FitnessPosterior, incumbent: float, chances: Array, count: int) -> list[int]:
    """The numbers of `count` points of most expected improvement, each as if the ones before were known.

    - `posterior`: of the points to choose from.
    - `incumbent`: the fitness to exceed.
    - `chances`: (points,) what expected improvements are multiplied by; 0 for a point that must not be
      chosen.
    - `count`: how many; fewer where no others may be chosen.

    Source: Ginsbourger et al. 2010, "Kriging is well-suited to parallelize optimization" (the Kriging
    believer).
    """
    chances = chances.copy()
    chosen: list[int] = []
    while len(chosen) < count and (chances > 0).any():
        if chosen:
            posterior = posterior.having_seen(chosen[-1])
        gains = expected_improvement(posterior, incumbent)
        tiny = 1e-12 * (
            np.abs(posterior.mean).max() + 1.0
        )  # where nothing can be gained, what is least known
        chosen.append(int(np.argmax((gains + tiny * posterior.sd) * chances)))
        chances[chosen[-1]] = 0.0
    return chosen


def most_promising(posterior: FitnessPosterior, chances: Array) -> int:
    """The number of the point that would be best if it were better than expected."""
    bound = posterior.mean + OPTIMISM * posterior.sd
    likely = chances >= min(0.5, float(chances.max()))
    return int(np.argmax(np.where(likely, bound, -np.inf)))
