"""Closure of the gap: by each effect alone, all together, and each one's share."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from tacos_gap.inference.fit import Fitted, held_parts_for, move_without, plain_jacobian
from tacos_gap.inference.jacobian import columns_of
from tacos_gap.inference.problem import Problem
from tacos_gap.inference.unknown import block_index


def closure(before: float, after: float, floor: float = 1.0) -> float:
    """Share of the squared gap above the noise floor that is gone.

    It is ``(before^2 - after^2) / (before^2 - floor^2)``: squares of independent differences add up, so that
    what each of several effects removes does, too.

    >>> closure(before=7.0, after=5.0)
    0.5
    """
    if before <= floor:
        return 0.0
    return float(np.clip((before**2 - after**2) / (before**2 - floor**2), -1.0, 1.0))


def shapley(names: Sequence[str], value: Callable[[tuple[str, ...]], float]) -> dict[str, float]:
    """Fair share of each effect in what all achieve together, by exact enumeration (Shapley 1953).

    - `value`: what a subset achieves, its names in the order of `names`; nothing achieves 0.

    >>> shapley(("a", "b"), lambda s: {(): 0, ("a",): 0.6, ("b",): 0.2, ("a", "b"): 1.0}[s])
    {'a': 0.7, 'b': 0.3}
    """
    if len(names) > 6:
        raise ValueError(f"{len(names)} effects take too many subsets; at most 6")
    known: Mapping[tuple[str, ...], float] = {
        subset: value(subset) for size in range(len(names) + 1) for subset in combinations(names, size)
    }
    count = len(names)
    shares = {}
    for name in names:
        others = [other for other in names if other != name]
        share = 0.0
        for size in range(count):
            weight = math.factorial(size) * math.factorial(count - size - 1) / math.factorial(count)
            for subset in combinations(others, size):
                joined = tuple(n for n in names if n in subset or n == name)
                share += weight * (known[joined] - known[subset])
        shares[name] = round(share, 6)
    return shares


@dataclass(frozen=True)
class Share:
    """A share of the gap with its 90 % interval."""

    value: float
    interval: tuple[float, float]

    @classmethod
    def of(cls, values: Sequence[float]) -> Share:
        """The first value, with an interval of the others that holds it."""
        low, high = np.percentile(values[1:], (5, 95)).tolist()
        return cls(values[0], (min(low, values[0]), max(high, values[0])))


@dataclass(frozen=True)
class Closures:
    """Closures of the gap by an explanation, its parameters held out."""

    together: Share  # by all effects
    fair: Mapping[str, Share]  # by each, as its fair share of that (Shapley 1953); they add up to `together`
    alone: Mapping[str, Share]  # by each if it were the only one, its parameters as fitted together


def closures_of(problem: Problem, best: Fitted, rng: np.random.Generator, draws: int = 200) -> Closures:
    """Closures of an explanation from the same numbers; intervals by resampled captures and statistics."""
    names = best.names
    subsets = [subset for size in range(len(names) + 1) for subset in combinations(names, size)]
    gaps = resampled_gaps(problem, np.stack([_left_by(problem, best, s) for s in subsets]), rng, draws)
    games = [
        {subset: closure(column[0], gap) for subset, gap in zip(subsets, column, strict=True)}
        for column in gaps.T.tolist()
    ]
    fair = [shapley(names, game.__getitem__) for game in games]
    return Closures(
        Share.of([game[names] for game in games]),
        {name: Share.of([shares[name] for shares in fair]) for name in names},
        {name: Share.of([game[(name,)] for game in games]) for name in names},
    )


def resampled_gaps(
    problem: Problem, left: NDArray[np.float64], rng: np.random.Generator, draws: int = 200
) -> NDArray[np.float64]:
    """(S, 1 + D) gaps that (S, K) residuals leave: of all, and of resampled captures and statistics."""
    groups, squares = block_index(problem), left**2
    count = int(groups.max()) + 1
    drawn = rng.integers(count, size=(draws, count))
    sums = np.stack([np.bincount(groups, each) for each in squares])
    resampled = sums[:, drawn].sum(axis=2) / np.bincount(groups)[drawn].sum(axis=1)
    return np.asarray(
        np.sqrt(np.hstack([squares.mean(axis=1)[:, None], resampled])) / max(problem.noise_floor_rms, 1e-9)
    )


def _left_by(problem: Problem, best: Fitted, names: Sequence[str]) -> NDArray[np.float64]:
    """(K,) residuals that some effects leave, their parameters of each fold from the other."""
    z = problem.residual(tuple(term for term in best.hypothesis if term.name in names))
    if z is None:
        return problem.null
    z = best.z if tuple(names) == best.names else z
    own = [k for k, (effect, *_) in enumerate(columns_of(best.hypothesis)) if effect in names]
    columns, predicted = plain_jacobian(best)[:, own], z.copy()
    for held in held_parts_for(problem, best.hypothesis):
        predicted[held] += columns[held] @ move_without(best, held)[own]
    return predicted
