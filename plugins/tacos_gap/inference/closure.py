"""How far the gap shrinks: each effect alone, all together, each one's share, and a negative control."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from tacos_gap.inference.fit import Fitted, fold_for, move_of_fold
from tacos_gap.inference.problem import Problem, robust
from tacos_gap.inference.unknown import block_index


def closure(before: float, after: float, floor: float = 1.0) -> float:
    """Share of the gap above the noise floor that is gone: ``(before - after) / (before - floor)``.

    Examples
    --------
    >>> closure(before=11.0, after=2.0)
    0.9
    """
    if before <= floor:
        return 0.0
    return float(np.clip((before - after) / (before - floor), -1.0, 1.0))


def shapley(names: Sequence[str], value: Callable[[tuple[str, ...]], float]) -> dict[str, float]:
    """Fair share of each effect in what all achieve together, by exact enumeration (Shapley 1953).

    Parameters
    ----------
    names
        The effects; at most six.
    value
        What a subset achieves, its names in the order of `names`; nothing achieves 0.

    Examples
    --------
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


@dataclass(frozen=True)
class Closures:
    """How far an explanation shrinks the gap, held out from its fit.

    Parameters
    ----------
    fair
        By each, as its fair share of that (Shapley 1953); they add up to `together`.
    alone
        By each if it were the only one, its parameters as fitted together.
    """

    together: Share
    fair: Mapping[str, Share]
    alone: Mapping[str, float]


def closures_of(problem: Problem, best: Fitted, rng: np.random.Generator, draws: int = 200) -> Closures:
    """Closures of an explanation, all from the same numbers; intervals by resampled captures and statistics.

    Parameters
    ----------
    problem
        The evidence, in the units of the explanation.
    best
        The explanation, of one to six effects.
    """
    names = best.names
    groups = block_index(problem)
    subsets = [subset for size in range(len(names) + 1) for subset in combinations(names, size)]
    left = np.stack([_left_by(problem, best, subset) for subset in subsets])
    own = np.mean(left, axis=1)[:, None]
    drawn = rng.integers(int(groups.max()) + 1, size=(draws, int(groups.max()) + 1))
    sums = np.stack([np.bincount(groups, squares) for squares in left])
    resampled = sums[:, drawn].sum(axis=2) / np.bincount(groups)[drawn].sum(axis=1)
    gaps = np.sqrt(np.hstack([own, resampled])) / max(problem.noise_floor_rms, 1e-9)
    games = [
        dict(
            zip(
                subsets,
                (
                    closure(column[0], gap) if subset else 0.0
                    for subset, gap in zip(subsets, column, strict=True)
                ),
                strict=True,
            )
        )
        for column in gaps.T.tolist()
    ]
    fair = [shapley(names, game.__getitem__) for game in games]
    return Closures(
        _share([game[names] for game in games]),
        {name: _share([shares[name] for shares in fair]) for name in names},
        {name: games[0][(name,)] for name in names},
    )


def _share(values: Sequence[float]) -> Share:
    """The first value, with an interval of the others that holds it."""
    low, high = np.percentile(values[1:], (5, 95)).tolist()
    return Share(values[0], (min(low, values[0]), max(high, values[0])))


def _left_by(problem: Problem, best: Fitted, names: Sequence[str]) -> NDArray[np.float64]:
    """(K,) squared robust residuals that some effects leave, held out where all are there."""
    if tuple(names) == best.names:
        return robust(best.held_out) ** 2
    z = problem.residual(tuple(term for term in best.hypothesis if term.name in names))
    return robust(problem.null if z is None else z) ** 2


@dataclass(frozen=True)
class NegativeControl:
    """What flexibility alone would close, with as many parameters as the explanation has.

    Parameters
    ----------
    closure
        The middle one of many controls; near 0 where the held-out score is to be trusted.
    interval
        That holds 90 % of them.
    """

    parameters: int
    closure: float
    interval: tuple[float, float]


def negative_control(
    problem: Problem, best: Fitted, rng: np.random.Generator, draws: int = 64
) -> NegativeControl | None:
    """Random directions in place of an explanation's own, fitted to one fold and scored on the other.

    They are the explanation's directions with the numbers of each block exchanged at random and turned
    about: they can do as much, in the same places, and mean nothing. None where nothing was fitted.
    """
    if not best.jacobian.shape[1]:
        return None
    blocks = [np.flatnonzero(block_index(problem) == k) for k in range(int(block_index(problem).max()) + 1)]
    straight = robust(problem.null)
    before, fold = problem.gap(problem.null), fold_for(problem, best.hypothesis)
    found = []
    for _ in range(draws):
        directions = np.empty_like(best.jacobian)
        for block in blocks:
            directions[block] = best.jacobian[rng.permutation(block)] * rng.choice((-1.0, 1.0))
        predicted = straight.copy()
        for held in (fold, ~fold):
            move = move_of_fold(directions[~held], straight[~held])
            predicted[held] = straight[held] + directions[held] @ move
        after = float(np.sqrt(np.mean(predicted**2)) / max(problem.noise_floor_rms, 1e-9))
        found.append(closure(before, after))
    low, middle, high = np.percentile(found, (5, 50, 95)).tolist()
    return NegativeControl(best.jacobian.shape[1], middle, (low, high))
