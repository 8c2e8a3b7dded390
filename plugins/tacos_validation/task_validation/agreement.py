"""Agreement of two sets of scores on the rank of cameras; pure statistics over noise seeds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.stats import rankdata, spearmanr

INTERVAL = (2.5, 97.5)
"""Percentiles that bound an interval over seeds."""


@dataclass(frozen=True)
class OverSeeds:
    """A figure that differs from seed to seed: its mean and the interval that holds 95 % of the seeds."""

    mean: float
    low: float
    high: float

    def __str__(self) -> str:
        digits = 0 if abs(self.mean) >= 100 else 2
        return f"{self.mean:.{digits}f} [{self.low:.{digits}f}, {self.high:.{digits}f}]"


@dataclass(frozen=True)
class Agreement:
    tau: OverSeeds  # Kendall's rank correlation (tau-b), in -1..1
    same: float  # share of the seeds under which both put everything in one order, in 0..1


def over_seeds(values: Sequence[float] | NDArray[np.float64]) -> OverSeeds:
    low, high = np.percentile(values, INTERVAL)
    return OverSeeds(float(np.mean(values)), float(low), float(high))


def rank_agreement(first: NDArray[np.float64], second: NDArray[np.float64]) -> Agreement:
    """Agreement of two sets of scores on the rank of the same things, seed by seed.

    - `first`, `second`: (seeds, things) scores; seeds are paired in their order, but independent of each
      other.

    >>> ours = np.array([[3.0, 2.0, 1.0], [30.0, 20.0, 10.0]])
    >>> theirs = np.array([[9.0, 8.0, 7.0], [9.0, 7.0, 8.0]])
    >>> agreement = rank_agreement(ours, theirs)
    >>> round(agreement.tau.mean, 3), agreement.same
    (0.667, 0.5)
    """
    same = (rankdata(first, axis=1) == rankdata(second, axis=1)).all(axis=1)
    return Agreement(over_seeds(kendall(first, second)), float(same.mean()))


def kendall(first: NDArray[np.float64], second: NDArray[np.float64]) -> NDArray[np.float64]:
    """(seeds,) Kendall's rank correlation (tau-b) of (seeds, things) scores.

    Two constant sets agree, a constant and another set tell nothing of each other.

    >>> first = np.array([[1.0, 2.0, 3.0], [1.0, 1.0, 1.0]])
    >>> second = np.array([[1.0, 3.0, 2.0], [5.0, 5.0, 5.0]])
    >>> kendall(first, second).round(3).tolist()
    [0.333, 1.0]
    """
    above = np.triu_indices(first.shape[1], 1)
    ours, theirs = (np.sign(scores[:, above[0]] - scores[:, above[1]]) for scores in (first, second))
    told = np.sqrt((ours != 0).sum(axis=1) * (theirs != 0).sum(axis=1))
    flat = ~(ours.any(axis=1) | theirs.any(axis=1))
    return np.where(flat, 1.0, (ours * theirs).sum(axis=1) / np.maximum(told, 1))


def level_agreement(first: NDArray[np.float64], second: NDArray[np.float64]) -> OverSeeds:
    """Spearman's rank correlation of (seeds, things) scores, seed by seed."""
    return over_seeds([_spearman(a, b) for a, b in zip(first, second, strict=True)])


def within(scores: NDArray[np.float64]) -> Agreement:
    """Agreement of (seeds, things) scores under one seed with those under the next: the noise's bound."""
    return rank_agreement(scores, np.roll(scores, 1, axis=0))


def separations(scores: NDArray[np.float64]) -> list[tuple[int, int, float]]:
    """Neighbours in the ranking by mean, best first, and how far apart they are.

    Returns: the better, the worse, and the mean of their difference over its standard deviation from seed to
    seed. Infinite where the difference never changes.

    >>> separations(np.array([[1.0, 5.0], [2.0, 7.0]]))
    [(1, 0, 6.363961030678928)]
    """
    order = np.argsort(-scores.mean(axis=0), kind="stable").tolist()
    found = []
    for better, worse in pairwise(order):
        difference = scores[:, better] - scores[:, worse]
        spread = float(difference.std(ddof=1)) if len(difference) > 1 else 0.0
        found.append((better, worse, float(difference.mean()) / spread if spread > 0 else np.inf))
    return found


def _spearman(first: NDArray[np.float64], second: NDArray[np.float64]) -> float:
    """Spearman's rank correlation; two constant sets agree, a constant and another set tell nothing."""
    flat = [bool(np.ptp(scores) == 0) for scores in (first, second)]
    if any(flat):
        return 1.0 if all(flat) else 0.0
    return float(spearmanr(first, second)[0])
