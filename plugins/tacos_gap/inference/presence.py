"""Presence of an effect, whatever else is there: judged by the captures that show it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_gap.inference.problem import Problem, robust
from tacos_gap.inference.unknown import SLACK, block_index


@dataclass(frozen=True)
class Proof:
    """Shares of the squared gap that prove an effect."""

    mimicked: float  # up to this share something else could look so
    proven: float  # from this one on nothing would, whatever is left elsewhere

    def by(self, share: float) -> float:
        """Score from 0 to 1 that nothing unknown looks like an effect that explains such a share.

        >>> BY_STATISTICS.by(0.5), round(BY_STATISTICS.by(0.8), 2), BY_STATISTICS.by(0.95)
        (0.0, 0.4, 1.0)
        """
        return float(np.clip((share - self.mimicked) / (self.proven - self.mimicked), 0.0, 1.0))


BY_STATISTICS = Proof(0.7, 0.95)
"""Effects that bend a statistic the same way explain much of what another one does to it."""

BY_PICTURES = Proof(0.6, 0.9)
"""Of a share that is the least of many resamples, and that no rival reaches."""


A_PART = 1 / 3
"""Share of what was wrong with a statistic and is mended, from which on an effect is no rest of another:
of two effects that both bend it, each mends about half."""


def share_explained(problem: Problem, with_it: NDArray[np.float64], without: NDArray[np.float64]) -> float:
    """Share of the squared gap that an effect explains in the statistics of captures where it shows.

    They count by what they gain, of large residuals by its logarithm. What flats prove, scenes that
    nothing explains do not disprove; and where a capture shows no gap, there is nothing to explain that
    could prove anything. What an effect mends of a statistic is held against all that was wrong with it:
    the rest that another effect leaves there may come of that one's exact form, and proves no further
    effect; but see `A_PART`.

    `with_it`, `without`: (K,) residuals of the explanation with the effect and without it [noise floor].
    """
    if not len(with_it):
        return 0.0
    blocks = block_index(problem)
    sizes = np.bincount(blocks)
    before, after, alone = (np.bincount(blocks, z**2) for z in (without, with_it, problem.null))
    gains = np.maximum(before - after, 0.0)
    if not gains.any():
        return 0.0
    above = np.maximum(before - sizes, 1e-9)
    explained = np.clip(1 - np.maximum(after - SLACK**2 * sizes, 0.0) / above, 0.0, 1.0)
    explained[before <= SLACK**2 * sizes] = 0.0
    of_all = np.clip(gains / np.maximum(alone - after, 1e-9) / A_PART, 0.0, 1.0)
    compressed = np.bincount(blocks, robust(without) ** 2 - robust(with_it) ** 2)
    counted = np.maximum(compressed, 1e-9 * gains)  # one steep statistic does not speak for all others
    return float(np.average(explained * np.where(alone > after, of_all, 1.0), weights=counted))
