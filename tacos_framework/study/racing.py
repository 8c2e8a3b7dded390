"""Racing: candidates are scored block by block, and those that are clearly behind are not scored further.

All candidates of a race see the same blocks (common random numbers), so block for block their difference is
due to the cameras. After each block every candidate is compared with the one that leads; it is dropped once
its mean paired difference exceeds some standard errors of that mean.

References
----------
O. Maron, A. W. Moore, "Hoeffding races", NIPS 1993; M. Birattari et al., "A racing algorithm for configuring
metaheuristics", GECCO 2002, for the paired kind.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from tacos_framework.contracts import Scores
from tacos_framework.fitness import Fitness, FitnessTerm, mean_scores

Key = Hashable


def contributions(blocks: Sequence[Scores], fitness: Fitness) -> NDArray[np.float64] | None:
    """What each block tells about the fitness: numbers whose mean is the fitness of all blocks together.

    Their spread is that of the fitness: ``std(ddof=1) / sqrt(n)`` is its standard error. Where every block
    reports every score, they are the fitnesses of the blocks. A score that only m of n blocks report enters
    by the usual linearisation of a ratio of means,

        f_b = F + sum_t w_t c_t (s_tb - mean_t),    c_t = (n / m) sqrt(m (n - 1) / ((m - 1) n)),

    over the terms t reported in block b; c_t makes the standard error of a single term that of its m values.

    Parameters
    ----------
    blocks
        Scores of each block; a block leaves out a score that has no meaning there. With several scenarios
        they are called ``scenario/node.score``.

    Returns
    -------
    (n,) float64, or None while a term was reported in fewer than two blocks.

    Examples
    --------
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


@dataclass(frozen=True)
class Behind:
    """How far a candidate lies behind another on the blocks both have seen.

    Parameters
    ----------
    difference
        Mean difference, its own minus the rival's [fitness].
    standard_error
        Standard error of that mean [fitness].
    blocks
        How many blocks were compared.
    """

    rival: Key
    difference: float
    standard_error: float
    blocks: int

    def __str__(self) -> str:
        return (
            f"dropped after {self.blocks} blocks: {-self.difference:.4g} behind the leader, "
            f"with a standard error of {self.standard_error:.2g}"
        )


@dataclass
class Race:
    """Who has seen which blocks, and who was dropped.

    Parameters
    ----------
    fitness
        The weighted sum of scores.
    standard_errors
        A candidate is dropped when it is further behind than this many.
    min_blocks
        Blocks every candidate is scored on before any is dropped.

    Examples
    --------
    >>> from tacos_framework.fitness import FitnessTerm
    >>> race = Race(Fitness((FitnessTerm("a", 1.0),)), standard_errors=2, min_blocks=3)
    >>> race.saw("good", [{"a": 1.0}, {"a": 3.0}, {"a": 2.0}])
    >>> race.saw("poor", [{"a": 0.5}, {"a": 2.6}, {"a": 1.4}])
    >>> race.saw("close", [{"a": 1.2}, {"a": 2.5}, {"a": 2.2}])
    >>> race.drop()
    ['poor']
    """

    fitness: Fitness
    standard_errors: float
    min_blocks: int
    blocks: dict[Key, list[Scores]] = field(default_factory=dict)
    dropped: dict[Key, Behind] = field(default_factory=dict)

    def saw(self, key: Key, blocks: Sequence[Scores]) -> None:
        """A candidate was scored on its next blocks, in the same order for all."""
        self.blocks.setdefault(key, []).extend(blocks)

    def withdraw(self, key: Key) -> None:
        """A candidate failed: it is compared with no longer."""
        self.blocks.pop(key, None)

    def drop(self) -> list[Key]:
        """Drop the candidates that are clearly behind on the blocks that all have seen; returns them."""
        racing = {key: blocks for key, blocks in self.blocks.items() if key not in self.dropped}
        shared = min(map(len, racing.values()), default=0)
        if shared < self.min_blocks:
            return []
        contributed = {key: contributions(blocks[:shared], self.fitness) for key, blocks in racing.items()}
        known = {key: values for key, values in contributed.items() if values is not None}
        if not known:
            return []
        leader = max(known, key=lambda key: known[key].mean())
        behind = {key: _behind(leader, known[leader], values) for key, values in known.items()}
        out = {
            key: gap
            for key, gap in behind.items()
            if key != leader and -gap.difference > self.standard_errors * gap.standard_error
        }
        self.dropped.update(out)
        return list(out)

    def fitness_of_dropped(self, fitnesses: Mapping[Key, float]) -> dict[Key, float]:
        """The fitness that stands for each dropped candidate.

        Its own mean is over other blocks than that of the candidates that saw all, and blocks differ more
        than cameras do. So the optimizer observes the fitness of the one it was dropped for, less what it was
        behind. Where that one has failed since, the best of those that saw all blocks stands in for it. It
        never ranks above a candidate that saw all blocks.

        Parameters
        ----------
        fitnesses
            Fitness of the candidates that saw all blocks.

        Returns
        -------
        Fitness of those that did not, by key; none where no candidate saw all blocks.
        """
        known = dict(fitnesses)
        for key, gap in reversed(self.dropped.items()):  # those dropped for it were dropped before it was
            behind = gap if gap.rival in known else self._behind_the_best(key, fitnesses)
            if behind is not None and key not in fitnesses:
                known[key] = known[behind.rival] + behind.difference
        return {key: fitness for key, fitness in known.items() if key not in fitnesses}

    def _behind_the_best(self, key: Key, fitnesses: Mapping[Key, float]) -> Behind | None:
        """How far a dropped candidate is behind the best that saw all blocks, on those both have seen.

        By a standard error at least, as it may have been lucky on those blocks.
        """
        raced = [each for each in fitnesses if each in self.blocks]
        leader = max(raced, key=lambda each: fitnesses[each], default=None)
        if leader is None:
            return None
        shared = min(len(self.blocks[leader]), len(self.blocks[key]))
        leading = contributions(self.blocks[leader][:shared], self.fitness)
        own = contributions(self.blocks[key][:shared], self.fitness)
        if leading is None or own is None:
            return None
        gap = _behind(leader, leading, own)
        return replace(gap, difference=min(gap.difference, -gap.standard_error))


def _behind(leader: Key, leading: NDArray[np.float64], values: NDArray[np.float64]) -> Behind:
    differences = values - leading
    error = float(differences.std(ddof=1)) / math.sqrt(len(differences))
    return Behind(leader, float(differences.mean()), error, len(differences))
