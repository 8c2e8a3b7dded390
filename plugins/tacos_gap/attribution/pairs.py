"""Pairs of effects that together explain what no single one does.

Forward selection takes the effect that gains most by itself. One with two parameters may gain more than
either of the two effects that are really there, and what it leaves is then shared among many others. So
before an effect is added, all pairs of others are looked at to first order.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from tacos_gap.hypotheses.parameters import HypothesisTerm
from tacos_gap.inference.problem import robust_derivative
from tacos_gap.inference.screening import (
    RIDGE,
    ScreeningDirection,
    ScreeningDirections,
    apart,
    combined_gain,
    combined_shares,
    term_at,
)

PROMISING = 3
"""Pairs of highest gain, by squares alone, that are looked at robustly."""


@dataclass(frozen=True, eq=False)
class Pair:
    """Two effects and what they could gain together."""

    gain: float  # fall of the sum of robust squares, to first order
    terms: tuple[HypothesisTerm, HypothesisTerm]  # where their fit begins


def best_pair(
    directions: ScreeningDirections, names: Iterable[str], base: NDArray[np.float64]
) -> Pair | None:
    """The pair of effects that could gain most on top of (K,) residuals; None where there are no two.

    `names`: effects that may be in the pair. `base`: (K,) residuals of the explanation so far [noise floor].
    """
    groups = {name: apart(directions[name], base) for name in names}
    if len(groups) < 2:
        return None
    changes = np.stack([one.change for group in groups.values() for one in group], axis=1)
    weights = robust_derivative(base)
    normal, slope = (changes * weights[:, None]).T @ changes, changes.T @ (weights * base)
    ends = np.cumsum([len(group) for group in groups.values()])
    columns = {
        name: np.arange(end - len(group), end)
        for (name, group), end in zip(groups.items(), ends, strict=True)
    }
    falls = {
        (one, other): _fall(normal, slope, np.concatenate([columns[one], columns[other]]))
        for one, other in combinations(groups, 2)
    }
    promising = sorted(falls, key=lambda pair: -falls[pair])[:PROMISING]
    found = [_begun(groups[one], groups[other], base) for one, other in promising]
    return max((pair for pair in found if pair is not None), key=lambda pair: pair.gain, default=None)


def _fall(normal: NDArray[np.float64], slope: NDArray[np.float64], at: NDArray[np.int64]) -> float:
    """Fall of the weighted squares where some directions are scaled as leaves least."""
    inner = normal[np.ix_(at, at)]
    ridge = RIDGE * float(np.trace(inner)) / len(at)
    return float(slope[at] @ np.linalg.solve(inner + ridge * np.eye(len(at)), slope[at]))


def _begun(
    one: Sequence[ScreeningDirection], other: Sequence[ScreeningDirection], base: NDArray[np.float64]
) -> Pair | None:
    """Two effects scaled as leaves least; None where one of them refuses that."""
    directions = [*one, *other]
    shares = combined_shares(directions, base)
    first, second = term_at(one, shares[: len(one)]), term_at(other, shares[len(one) :])
    if first is None or second is None:
        return None
    return Pair(combined_gain(directions, shares, base), (first, second))
