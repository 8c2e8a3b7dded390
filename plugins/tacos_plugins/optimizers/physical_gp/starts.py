"""The first candidates: spread over what images depend on."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ALIKE = 0.9
"""Coordinates of a larger correlation say the same, as horizontal and vertical fields of view do."""


def spread_out(rows: Array, count: int, rng: np.random.Generator) -> list[int]:
    """The numbers of at most `count` rows nearest to a Latin hypercube over the ranks of their coordinates.

    Ranks among what can be had: with few small sensors and many large ones, large ones are drawn more often.

    `rows`: (points, names) scaled coordinates of those to choose from.

    Source: McKay et al. 1979, "A comparison of three methods for selecting values of input variables".
    """
    from scipy.stats import qmc, rankdata  # late: checking a recipe draws nothing

    table = np.nan_to_num(rows, nan=0.5)
    ranks = rankdata(table, axis=0) / len(table) if len(table) else table
    columns = _independent(ranks)
    left = np.ones(len(ranks), dtype=bool)
    chosen: list[int] = []
    for target in qmc.LatinHypercube(max(len(columns), 1), rng=rng).random(count):
        if not left.any():
            break
        distances = ((ranks[:, columns] - target[: len(columns)]) ** 2).sum(axis=1)
        chosen.append(int(np.argmin(np.where(left, distances, np.inf))))
        left[chosen[-1]] = False
    return chosen


def _independent(ranks: Array) -> list[int]:
    """The columns that vary, without those that say what an earlier one says."""
    kept: list[int] = []
    for column in range(ranks.shape[1]):
        own = ranks[:, column]
        if np.ptp(own) > 0 and all(abs(np.corrcoef(own, ranks[:, other])[0, 1]) < ALIKE for other in kept):
            kept.append(column)
    return kept
