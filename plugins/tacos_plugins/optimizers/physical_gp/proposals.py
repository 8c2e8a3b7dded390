"""From a model and a pool to the candidates of a round, and to those that are recommended."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Candidate
from tacos_plugins.optimizers.physical_gp.acquisition import (
    chosen_in_turn,
    expected_improvement,
    most_promising,
)
from tacos_plugins.optimizers.physical_gp.model import SearchModel
from tacos_plugins.optimizers.physical_gp.pool import Genes, Located, Pool
from tacos_plugins.surrogate.fitness_posterior import FitnessPosterior

Array = NDArray[np.float64]

FINALISTS = 128
"""Candidates of the pool that go on to the second comparison, with those drawn around the best."""

CENTRES, NEIGHBOURS = 4, 32
"""Around how many of the best new candidates are drawn each round, and how many at each step size."""

STEPS = (0.06, 0.015)
"""Sizes of steps around the best, in ranges of a variable."""

GLOBAL_SHARE = 10
"""One in so many of the pool, drawn at random, is looked at for a global candidate."""

APART = 0.05
"""Recommended candidates differ by so much of a coordinate's range, where there are enough of them."""


@dataclass(frozen=True)
class Proposal:
    """The candidates to ask next."""

    candidates: tuple[Candidate, ...]
    gain: float
    """By how much the first is expected to exceed the best, as a share of its fitness."""


def proposed(
    model: SearchModel,
    pool: Pool,
    tried: Located,
    closed: Collection[Genes],
    count: int,
    rng: np.random.Generator,
) -> Proposal:
    """The candidates of largest expected improvement, at most `count`.

    `tried`: the candidates that could be evaluated. `closed`: genes of those that must not be asked.
    """
    known = Assessed.of(model, pool.everywhere.joined(tried))
    near = _with_neighbours(known.located, known.gains(known.best_mean), pool, rng)
    incumbent = max(known.best_mean, Assessed.of(model, near).best_mean)
    left = near.without(closed)
    among = Assessed.of(model, left if len(left) else pool.others(rng).without(closed))
    chosen = chosen_in_turn(among.posterior, incumbent, among.chances, count)
    gain = float(among.gains(incumbent).max()) / max(abs(incumbent), 1e-12)
    return Proposal(among.located.take(chosen).candidates, gain)


def might_be_best(
    model: SearchModel, pool: Pool, closed: Collection[Genes], rng: np.random.Generator
) -> Candidate | None:
    """A candidate that is good or unknown, of some drawn at random; None where none is left."""
    left = pool.everywhere.without(closed)
    if not len(left):
        return None
    some = Assessed.of(model, left.take(rng.permutation(len(left))[: -(-len(left) // GLOBAL_SHARE)]))
    return some.located.candidates[most_promising(some.posterior, some.chances)]


def recommended(
    model: SearchModel, pool: Pool, tried: Located, count: int, rng: np.random.Generator
) -> list[Candidate]:
    """The candidates of highest mean fitness, tried or not, the best first, and not all alike."""
    known = Assessed.of(model, pool.everywhere.joined(tried))
    among = Assessed.of(model, _with_neighbours(known.located, known.likely_means, pool, rng))
    order = np.argsort(-among.likely_means, kind="stable").tolist()
    rows = np.nan_to_num(among.located.rows, nan=0.5)
    return list(among.located.take(_apart(rows, order, count)).candidates)


@dataclass(frozen=True, eq=False)
class Assessed:
    """Candidates, and what a model says of them."""

    located: Located
    posterior: FitnessPosterior
    chances: Array
    """(candidates,) probability that each can be evaluated."""

    @classmethod
    def of(cls, model: SearchModel, located: Located) -> Assessed:
        """The model's view of these."""
        return cls(located, model.grey_box.posterior_at(located.rows), model.viability.chances(located.rows))

    @property
    def likely_means(self) -> Array:
        """(candidates,) mean fitness; of those that will rather fail, unless all will, as low as can be."""
        likely = self.chances >= min(0.5, float(self.chances.max()))
        return np.where(likely, self.posterior.mean, -np.inf)

    @property
    def best_mean(self) -> float:
        """The largest mean fitness, of candidates that need not have been tried."""
        return float(self.likely_means.max())

    def gains(self, incumbent: float) -> Array:
        """(candidates,) improvement to be expected over a fitness."""
        return expected_improvement(self.posterior, incumbent) * self.chances


def _with_neighbours(located: Located, worth: Array, pool: Pool, rng: np.random.Generator) -> Located:
    """Those worth most, and some around the best of them."""
    best = located.take(np.argsort(-worth, kind="stable")[:FINALISTS])
    near = [pool.around(best.candidates[:CENTRES], NEIGHBOURS, step, rng) for step in STEPS]
    return best.joined(*near)


def _apart(rows: Array, order: list[int], count: int) -> list[int]:
    """The first `count` rows in an order that differ from one another; any others where so many do not."""
    chosen: list[int] = []
    for index in order:
        if len(chosen) == count:
            break
        if all(np.abs(rows[index] - rows[other]).max(initial=0.0) >= APART for other in chosen):
            chosen.append(index)
    rest = [index for index in order if index not in chosen]
    return (chosen + rest)[:count]
