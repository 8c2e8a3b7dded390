"""From a model and a pool to the candidates of a round, and to those that are recommended."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_framework.variables.design_space import Candidate
from tacos_plugins.optimizers.physical_gp.acquisition import (
    chosen_in_turn,
    expected_improvement,
    most_promising,
)
from tacos_plugins.optimizers.physical_gp.model import SearchModel
from tacos_plugins.optimizers.physical_gp.pool import Genes, Located, Pool

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
    """What to ask next.

    Parameters
    ----------
    candidates
        Which.
    gain
        By how much the first is expected to exceed the best, as a share of its fitness.
    """

    candidates: tuple[Candidate, ...]
    gain: float


def proposed(
    model: SearchModel,
    pool: Pool,
    tried: Located,
    closed: Collection[Genes],
    count: int,
    rng: np.random.Generator,
) -> Proposal:
    """The candidates of largest expected improvement, at most `count`.

    Parameters
    ----------
    model
        What is known.
    pool
        What there is.
    tried
        The candidates that could be evaluated.
    closed
        Genes of those that must not be asked.
    """
    incumbent = float(model.grey_box.posterior_at(tried.rows).mean.max())
    left = pool.everywhere.without(closed)
    left = left if len(left) else pool.others(rng).without(closed)
    gains = expected_improvement(model.grey_box.posterior_at(left.rows), incumbent)
    among = _with_neighbours(left, gains * model.chances(left.rows), pool, rng).without(closed)
    posterior, chances = model.grey_box.posterior_at(among.rows), model.chances(among.rows)
    gain = float((expected_improvement(posterior, incumbent) * chances).max())
    chosen = among.take(chosen_in_turn(posterior, incumbent, chances, count))
    return Proposal(chosen.candidates, gain / max(abs(incumbent), 1e-12))


def might_be_best(
    model: SearchModel, pool: Pool, closed: Collection[Genes], rng: np.random.Generator
) -> Candidate | None:
    """A candidate that is good or unknown, of some drawn at random; None where none is left."""
    left = pool.everywhere.without(closed)
    some = left.take(rng.permutation(len(left))[: -(-len(left) // GLOBAL_SHARE)])
    if not len(some):
        return None
    return some.candidates[most_promising(model.grey_box.posterior_at(some.rows), model.chances(some.rows))]


def recommended(
    model: SearchModel, pool: Pool, tried: Located, count: int, rng: np.random.Generator
) -> list[Candidate]:
    """The candidates of highest mean fitness, tried or not, the best first, and not all alike."""
    known = pool.everywhere.joined(tried)
    among = _with_neighbours(known, _likely_means(model, known), pool, rng)
    order = np.argsort(-_likely_means(model, among), kind="stable").tolist()
    return list(among.take(_apart(np.nan_to_num(among.rows, nan=0.5), order, count)).candidates)


def _with_neighbours(located: Located, worth: Array, pool: Pool, rng: np.random.Generator) -> Located:
    """Those worth most, and some around the best of them."""
    best = located.take(np.argsort(-worth, kind="stable")[:FINALISTS])
    near = [pool.around(best.candidates[:CENTRES], NEIGHBOURS, step, rng) for step in STEPS]
    return best.joined(*near)


def _likely_means(model: SearchModel, located: Located) -> Array:
    """(candidates,) mean fitness; that of those that will rather fail is as low as can be."""
    mean = model.grey_box.posterior_at(located.rows).mean
    return np.where(model.chances(located.rows) >= 0.5, mean, -np.inf)


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
