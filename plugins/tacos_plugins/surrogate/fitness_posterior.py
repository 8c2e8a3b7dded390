"""Posterior of the fitness at points that need never have been simulated."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Fitness
from tacos_plugins.surrogate.gaussian_process import Prediction, factorised
from tacos_plugins.surrogate.score_model import ScoreModel

Array = NDArray[np.float64]

MARGINAL_DRAWS = 256
"""Points of a quasi-random rule over the scores; means and deviations are then good to half a per cent."""


def score_names(fitness: Fitness) -> list[str]:
    """The scores of the fitness: ``node.score``, or ``scenario/node.score`` where there are several."""
    scores = [term.score for term in fitness.terms]
    if not fitness.scenarios:
        return scores
    return [f"{scenario}/{score}" for scenario, _ in fitness.scenarios for score in scores]


def combined(fitness: Fitness, scores: Mapping[str, Array]) -> Array:
    """The fitness for arrays of scores of equal shape, by name; one that is not there counts as zero.

    Raises `ValueError` when there is no score at all.
    """
    if not scores:
        raise ValueError("there is no score to make a fitness of")
    shape = np.broadcast_shapes(*(np.shape(values) for values in scores.values()))

    def of_scenario(prefix: str) -> Array:
        total = np.zeros(shape)
        for term in fitness.terms:
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
    from scipy.special import ndtri  # late: checking a recipe predicts nothing
    from scipy.stats import qmc

    if not dimension:
        return np.zeros((count, 0))
    sobol = qmc.Sobol(dimension, scramble=True, rng=np.random.default_rng(0))
    return np.asarray(ndtri(sobol.random(count)), dtype=np.float64)


@dataclass(frozen=True, eq=False)
class FitnessPosterior:
    """The fitness at points, averaged over scenes: what a study on many scenes would find."""

    fitness: Fitness
    """Weights of the scores and of the scenarios."""
    models: Mapping[str, ScoreModel]
    """A model of each score, by name."""
    predictions: Mapping[str, Prediction]
    """Prediction of each at the points."""
    count: int

    @classmethod
    def at(cls, rows: Array, fitness: Fitness, models: Mapping[str, ScoreModel]) -> FitnessPosterior:
        """The fitness at (points, names) scaled coordinates."""
        return cls(fitness, models, {name: model.at(rows) for name, model in models.items()}, len(rows))

    def having_seen(self, index: int) -> FitnessPosterior:
        """The fitness as known once the point of this number has scored its mean in a new scene."""
        seen = {name: prediction.having_seen(index) for name, prediction in self.predictions.items()}
        return replace(self, predictions=seen)

    def marginal_draws(self, normal: Array) -> Array:
        """(draws, points) fitness, each point's right by itself but not the points' among one another.

        `normal`: (draws, scores) standard normal numbers.
        """
        if not self.models:
            return np.zeros((len(normal), self.count))
        scores = {}
        for column, (name, prediction) in zip(normal.T, self.predictions.items(), strict=True):
            scores[name] = self.models[name].scores(prediction.mean + column[:, None] * prediction.sd)
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
            name: self.models[name].scores(prediction.mean + normal * prediction.sd).mean(axis=0)
            for name, prediction in self.predictions.items()
        }

    def draws(self, count: int, rng: np.random.Generator) -> Array:
        """(count, points) fitness, drawn for all points together: what is near is alike in each draw.

        Of draws, any statement about several points follows: which is best, and how surely.
        """
        if not self.models:
            return np.zeros((count, self.count))
        scores = {}
        for name, prediction in self.predictions.items():
            factor = factorised((prediction.covariance + prediction.covariance.T) / 2)
            values = prediction.mean + rng.standard_normal((count, self.count)) @ factor.T
            scores[name] = self.models[name].scores(values)
        return combined(self.fitness, scores)
