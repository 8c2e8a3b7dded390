"""Significance: how seldom the simulator differs from itself as much as from the camera, block by block."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import f as fisher

_EULER = 0.5772156649
_LEAST_FREEDOM = 1.0  # of numbers that all vary as one
_LEAST_MEAN = 1e-3  # of a sum of squares in units of the noise floor: blocks without noise


@dataclass(frozen=True, eq=False)
class BlockTest:
    """p-values of blocks (a statistic of a capture) and of the most extreme one among many."""

    p_values: NDArray[np.float64]  # (M,) of each block alone
    location: float
    """Of the Gumbel distribution, as `spread`, that the largest -log p of all blocks follows in the
    simulator's own replicates, each tested against the others."""
    spread: float

    def least_p_value(self, p_value: float) -> float:
        """The p-value of a block by itself at which the family's is `p_value`."""
        return float(np.exp(-(self.location - self.spread * np.log(-np.log1p(-p_value)))))

    def family_p_value(self, part: NDArray[np.bool_] | None = None) -> float:
        """p-value of the most extreme block of all, or of some."""
        chosen = self.p_values if part is None else self.p_values[part]
        if not chosen.size:
            return 1.0
        fewer = self.location + self.spread * np.log(chosen.size / self.p_values.size)
        extreme = (-np.log(max(float(chosen.min()), 1e-300)) - fewer) / self.spread
        return float(-np.expm1(-np.exp(-np.clip(extreme, -30, 700))))


def block_test(
    z: NDArray[np.float64], replicates: NDArray[np.float64], blocks: NDArray[np.int64], slack: float = 1.0
) -> BlockTest:
    """Test the sum of squares of each block.

    Against B replicates of mean m and variance v it follows m F(d, B d), d = 2 m^2 / v, if squares are a
    scaled chi-squared (Satterthwaite 1946, Biometrics Bulletin 2(6)) whose scale is as uncertain as B of them
    leave it.

    - `replicates`: (B, K) the simulator against itself [noise floor].
    - `blocks`: (K,) the block of each number.
    - `slack`: what residuals may exceed the noise floor by, as a factor.
    """
    count = int(blocks.max()) + 1 if blocks.size else 0
    sizes = np.bincount(blocks, minlength=count)
    own = np.bincount(blocks, z**2, count) / slack**2
    floor = np.array([np.bincount(blocks, each**2, count) for each in replicates], float)
    p_values = _p_values(own, floor, sizes)
    if len(floor) < 4 or not count:
        return BlockTest(p_values, float(np.log(max(count, 1))), 1.0)
    others = [np.delete(floor, k, axis=0) for k in range(len(floor))]
    extremes = [
        -np.log(max(float(_p_values(each, rest, sizes).min()), 1e-300))
        for each, rest in zip(floor, others, strict=True)
    ]
    spread = max(float(np.std(extremes, ddof=1)) * np.sqrt(6) / np.pi, 1.0)
    return BlockTest(p_values, float(np.mean(extremes)) - _EULER * spread, spread)


def least_significant(
    z: NDArray[np.float64],
    replicates: NDArray[np.float64],
    blocks: NDArray[np.int64],
    p_value: float,
    slack: float = 1.0,
) -> NDArray[np.float64]:
    """(M,) what the squares of each block must grow by for the block by itself to be significant.

    The reverse of `block_test`, whose parameters these are: at what they are then, the p-value of the
    family is `p_value`. They grow from what they are, or from their mean where that is less: noise may be
    smaller than the noise floor, which equivalence margins are part of.
    """
    test = block_test(z, replicates, blocks, slack)
    floor = np.array([np.bincount(blocks, each**2) for each in replicates], float)
    sizes = np.bincount(blocks)
    mean, freedom = _floor_of(floor, sizes)
    critical = slack**2 * mean * fisher.isf(test.least_p_value(p_value), freedom, len(floor) * freedom)
    return np.asarray(np.maximum(critical, sizes) - np.minimum(mean, np.bincount(blocks, z**2)))


def _p_values(
    own: NDArray[np.float64], floor: NDArray[np.float64], sizes: NDArray[np.signedinteger[Any]]
) -> NDArray[np.float64]:
    """(M,) upper tails."""
    mean, freedom = _floor_of(floor, sizes)
    return np.asarray(fisher.sf(own / mean, freedom, len(floor) * freedom))


def _floor_of(
    floor: NDArray[np.float64], sizes: NDArray[np.signedinteger[Any]]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(M,) means and degrees of freedom of (B, M) sums of squares: at most the numbers of a block."""
    mean = np.maximum(floor.mean(axis=0), _LEAST_MEAN * sizes)
    freedom = 2 * mean**2 / np.maximum(floor.var(axis=0, ddof=1), 1e-12)
    return mean, np.clip(freedom, _LEAST_FREEDOM, sizes)


def discoveries(p_values: NDArray[np.float64], rate: float) -> NDArray[np.bool_]:
    """(M,) which p-values are discoveries at a false discovery rate (Benjamini and Hochberg 1995)."""
    order = np.argsort(p_values)
    limits = rate * np.arange(1, len(p_values) + 1) / max(len(p_values), 1)
    below = np.flatnonzero(p_values[order] <= limits)
    found = np.zeros(len(p_values), bool)
    if len(below):
        found[order[: below[-1] + 1]] = True
    return found
