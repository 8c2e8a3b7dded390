"""Problems with a known optimum, and how close a search comes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from tacos_framework.contracts import Evaluated
from tacos_framework.variables.design_space import Candidate, Continuous, DesignSpace, Integer

SMOOTH = DesignSpace([Continuous(name, 0, 10, "m") for name in "abcd"])
"""Four lengths; `smooth` is best at 6.3 m each, where it is zero."""

MIXED = DesignSpace([Continuous("a", -1, 1, "m"), Continuous("b", 0, 100, "deg"), Integer("n", 1, 30)])
"""Two numbers and a count; `mixed` is best at (0.4, 70, 21), where it is zero."""


def smooth(candidate: Candidate) -> float:
    return -float(np.sum((np.array(candidate.genes) - 6.3) ** 2 * [1, 2, 4, 8]))


def mixed(candidate: Candidate) -> float:
    a, b, n = candidate.genes
    return -abs(a - 0.4) - abs(b - 70) / 50 - abs(n - 21) / 15


def search(optimizer: Any, fitness: Callable[[Candidate], float | None]) -> float:
    best = -np.inf
    while optimizer.stop() is None:
        observed = [Evaluated(candidate, fitness(candidate)) for candidate in optimizer.ask()]
        best = max(best, *(result.fitness for result in observed if result.fitness is not None), -np.inf)
        optimizer.tell(observed)
    return best


def regret(make: Callable[[int], Any], fitness: Callable[[Candidate], float | None], seeds: int) -> float:
    """Median distance of the best fitness from zero, over seeds."""
    return float(np.median([-search(make(seed), fitness) for seed in range(seeds)]))
