"""Whether an effect is there, whatever else is: judged by the captures that show it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tacos_gap.problem import Problem, robust
from tacos_gap.unknown import SLACK, block_index

MIMICKED, PROVEN = 0.6, 0.9
"""Shares of the squared gap that an effect explains where it shows. Up to the first something else could look
so; from the second on nothing would, whatever is left elsewhere."""


def share_explained(problem: Problem, with_it: NDArray[np.float64], without: NDArray[np.float64]) -> float:
    """Share of the squared gap that an effect explains in the statistics of captures where it shows.

    They count by what they gain. What flats prove, scenes that nothing explains do not disprove; and where a
    capture shows no gap, there is nothing to explain that could prove anything.

    Parameters
    ----------
    problem
        The evidence.
    with_it, without
        (K,) residuals of the explanation with the effect and without it [noise floor].
    """
    if not len(with_it):
        return 0.0
    blocks = block_index(problem)
    sizes = np.bincount(blocks)
    before, after = (np.bincount(blocks, robust(z) ** 2) for z in (without, with_it))
    gains = np.maximum(before - after, 0.0)
    if not gains.any():
        return 0.0
    above = np.maximum(before - sizes, 1e-9)
    explained = np.clip(1 - np.maximum(after - SLACK**2 * sizes, 0.0) / above, 0.0, 1.0)
    explained[before <= SLACK**2 * sizes] = 0.0
    return float(np.average(explained, weights=gains))


def shown(share: float) -> float:
    """Probability that nothing unknown looks like an effect which explains such a share where it shows.

    Examples
    --------
    >>> shown(0.5), round(shown(0.75), 2), shown(0.95)
    (0.0, 0.5, 1.0)
    """
    return float(np.clip((share - MIMICKED) / (PROVEN - MIMICKED), 0.0, 1.0))
