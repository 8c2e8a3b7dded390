"""Contribution of each block of scores to a fitness that is a sum of means."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tacos_framework.contracts import Scores
from tacos_framework.fitness import Fitness, FitnessTerm, mean_scores


def contributions(blocks: Sequence[Scores], fitness: Fitness) -> NDArray[np.float64] | None:
    """Contribution of each block to the fitness: numbers whose mean is the fitness of all blocks together.

    Their spread is that of the fitness: ``std(ddof=1) / sqrt(n)`` is its standard error. Where every block
    reports every score, they are the fitnesses of the blocks. A score that only m of n blocks report enters
    by the usual linearisation of a ratio of means,

        f_b = F + sum_t w_t c_t (s_tb - mean_t),    c_t = (n / m) sqrt(m (n - 1) / ((m - 1) n)),

    over the terms t reported in block b; c_t makes the standard error of a single term that of its m values.

    `blocks`: scores of each block; a block leaves out a score that has no meaning there. With several
    scenarios they are called ``scenario/node.score``.

    Returns: (n,) float64, or None while a term was reported in fewer than two blocks.

    >>> from tacos_framework.fitness import FitnessTerm
    >>> contributions([{"a": 1.0}, {"a": 3.0}], Fitness((FitnessTerm("a", 2.0),))).tolist()
    [2.0, 6.0]
    """
    n = len(blocks)
    total = 0.0
    deviations = np.zeros(n)
    terms = _counted_terms(blocks, fitness)
    if terms is None:
        return None
    for term in terms:
        reported = np.array([term.score in scores for scores in blocks])
        m = int(reported.sum())
        if m < 2:
            return None
        values = np.array([scores[term.score] for scores in blocks if term.score in scores])
        total += term.weight * float(values.mean())
        scale = n / m * math.sqrt(m * (n - 1) / ((m - 1) * n))
        deviations[reported] += term.weight * scale * (values - values.mean())
    return total + deviations


def _counted_terms(blocks: Sequence[Scores], fitness: Fitness) -> tuple[FitnessTerm, ...] | None:
    """The terms of the fitness over all scenarios, or of the worst so far; None where they cannot be told."""
    if not fitness.scenarios:
        return fitness.terms
    means = mean_scores(blocks)
    by_scenario = {
        name: {term.score: means[key] for term in fitness.terms if (key := f"{name}/{term.score}") in means}
        for name, _ in fitness.scenarios
    }
    if any(len(scores) < len(fitness.terms) for scores in by_scenario.values()):
        return None
    return tuple(
        FitnessTerm(f"{name}/{term.score}", weight * term.weight)
        for name, weight in fitness.weights(by_scenario).items()
        if weight > 0
        for term in fitness.terms
    )
