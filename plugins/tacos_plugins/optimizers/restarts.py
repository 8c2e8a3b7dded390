"""When and how CMA-ES starts over: growing populations, or growing and small ones in turn."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

MOST_DOUBLINGS = 6
"""Doublings of the population; beyond, a generation would be a study of its own."""


@dataclass(frozen=True)
class Descent:
    population: int
    sigma: float
    """First standard deviation, in edges of the unit cube [1]."""


class Restarts:
    """The sequence of descents of a run.

    ``ipop`` doubles the population at each restart, up to `MOST_DOUBLINGS` times. ``bipop`` alternates two
    regimes, giving the next descent to the one that has spent fewer evaluations: a large one as in ``ipop``,
    and a small one with

        lambda = floor(lambda_0 (lambda_large / (2 lambda_0))^(U^2)),    sigma = sigma_0 10^(-2 U),

    U uniform in 0..1, drawn for each.

    Sources: Auger and Hansen 2005; Hansen 2009, Sec. 2.
    """

    def __init__(
        self, kind: Literal["bipop", "ipop", "none"], population: int, sigma: float, rng: np.random.Generator
    ) -> None:
        self.again = kind != "none"
        self._kind = kind
        self._first = Descent(population, sigma)
        self._rng = rng
        self._large = population
        self._is_small = False
        self._begun = 0
        self._began_at = 0
        self._spent = {True: 0, False: 0}  # evaluations by regime, small or not

    def next(self, evaluations: int) -> Descent:
        """The next descent, after so many evaluations in all."""
        self._spent[self._is_small] += evaluations - self._began_at
        self._began_at = evaluations
        self._begun += 1
        if self._begun == 1:
            self._spent = {True: 0, False: 0}  # what came before the first descent belongs to neither
            return self._first
        self._is_small = self._kind == "bipop" and self._spent[True] < self._spent[False]
        return self._small_descent() if self._is_small else self._large_descent()

    def _large_descent(self) -> Descent:
        self._large = min(2 * self._large, self._first.population * 2**MOST_DOUBLINGS)
        return Descent(self._large, self._first.sigma)

    def _small_descent(self) -> Descent:
        first, (shrink, narrow) = self._first, self._rng.random(2)
        growth = max(1.0, self._large / (2 * first.population))
        population = int(first.population * growth ** (shrink**2))
        return Descent(population, first.sigma * 10 ** (-2 * narrow))
