"""What is known of the fitness at points that need never have been simulated."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri
from scipy.stats import qmc

from tacos_framework.fitness import Fitness
from tacos_plugins.surrogate.gaussian_process import factorised
from tacos_plugins.surrogate.score_model import ScoreModel

Array = NDArray[np.float64]

MARGINAL_DRAWS = 256
"""Points of a quasi-random rule over the scores; means and deviations are then good to half a per cent."""


def score_names(fitness: Fitness) -> list[str]:
    """The scores of the fitness: ``node.score``, or ``scenario/node.score`` where there are several."""
    scores = [term.score for term in fitness.terms_of]
    if not fitness.scenarios:
        return scores
    return [f"{scenario}/{score}" for scenario, _ in fitness.scenarios for score in scores]


def combined(fitness: Fitness, scores: Mapping[str, Array]) -> Array:
    """The fitness for arrays of scores of equal shape, by name; one that is not there counts as zero.

    Raises
    ------
    ValueError
        When there is no score at all.
    """
    if not scores:
        raise ValueError("there is no score to make a fitness of")
    shape = np.broadcast_shapes(*(np.shape(values) for values in scores.values()))

    def of_scenario(prefix: str) -> Array:
        total = np.zeros(shape)
        for term in fitness.terms_of:
            if (name := prefix + term.score) in scores:
                total = total + term.weight * scores[name]
        return total

    if not fitness.scenarios:
        return of_scenario("")
    by_scenario = {name: of_scenario(f"{name}/") for name, _ in fitness.scenarios}
    if fitness.over == "worst":
        return np.asarray(np.min(list(by_scenario.values()), axis=0))
    weights = fitness.mean_weights
    return np.asarray(sum(weights[name] * values for name, values in by_scenario.items()))


def normal_rule(count: int, dimension: int) -> Array:
    """(count, dimension) quasi-random standard normal numbers, always the same; `count` a power of two."""
    if not dimension:
        return np.zeros((count, 0))
    sobol = qmc.Sobol(dimension, scramble=True, rng=np.random.default_rng(0))
    return np.asarray(ndtri(sobol.random(count)), dtype=np.float64)


@dataclass(frozen=True, eq=False)
class FitnessPosterior:
    """The fitness at points, averaged over scenes: what a new study on many scenes would find.

    Parameters
    ----------
    fitness
        Weights of the scores and of the scenarios.
    models
        A model of each score.
    rows
        (points, names) scaled coordinates.
    """

    fitness: Fitness
    models: Mapping[str, ScoreModel]
    rows: Array

    @cached_property
    def marginals(self) -> dict[str, tuple[Array, Array]]:
        """For each score, mean and standard deviation of its process at each point, centred and scaled."""
        return {name: model.predict(self.rows) for name, model in self.models.items()}

    def marginal_draws(self, normal: Array) -> Array:
        """(draws, points) fitness, each point's right by itself but not the points' among one another.

        Parameters
        ----------
        normal
            (draws, scores) standard normal numbers.
        """
        if not self.models:
            return np.zeros((len(normal), len(self.rows)))
        scores = {}
        for column, (name, (mean, sd)) in zip(normal.T, self.marginals.items(), strict=True):
            scores[name] = self.models[name].scores(mean + column[:, None] * sd)
        return combined(self.fitness, scores)

    @cached_property
    def _draws(self) -> Array:
        return self.marginal_draws(normal_rule(MARGINAL_DRAWS, len(self.models)))

    @cached_property
    def mean(self) -> Array:
        """(points,) mean of the fitness."""
        return np.asarray(self._draws.mean(axis=0))

    @cached_property
    def sd(self) -> Array:
        """(points,) standard deviation of the fitness: how far it may be from its mean, not its noise."""
        return np.asarray(self._draws.std(axis=0))

    def score_means(self) -> dict[str, Array]:
        """(points,) mean of each score, by name, in its own unit."""
        normal = normal_rule(MARGINAL_DRAWS, 1)
        return {
            name: self.models[name].scores(mean + normal * sd).mean(axis=0)
            for name, (mean, sd) in self.marginals.items()
        }

    def draws(self, count: int, rng: np.random.Generator) -> Array:
        """(count, points) fitness, drawn for all points together: what is near is alike in each draw.

        Of draws, any statement about several points follows: which is best, and how surely.
        """
        if not self.models:
            return np.zeros((count, len(self.rows)))
        scores = {}
        for name, model in self.models.items():
            mean, covariance = model.predict_jointly(self.rows)
            factor = factorised((covariance + covariance.T) / 2)
            values = mean + rng.standard_normal((count, len(self.rows))) @ factor.T
            scores[name] = model.scores(values)
        return combined(self.fitness, scores)
