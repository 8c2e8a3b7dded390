"""How far the gap shrinks: each effect alone, all together, each one's share, and a negative control."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from itertools import combinations

import numpy as np
from numpy.typing import NDArray


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


def bootstrap_interval(
    before: NDArray[np.float64],
    after: NDArray[np.float64],
    floor: float,
    groups: NDArray[np.int64],
    rng: np.random.Generator,
    draws: int = 200,
) -> tuple[float, float]:
    """90 % interval of a closure over resampled groups of numbers (captures and statistics).

    Parameters
    ----------
    before, after
        (K,) squared residuals.
    floor
        Root mean square of the noise floor.
    groups
        (K,) the group each number belongs to.
    """
    count = int(groups.max()) + 1
    sums = np.stack([np.bincount(groups, values, count) for values in (before, after)])
    sizes = np.bincount(groups, minlength=count)
    drawn = rng.integers(count, size=(draws, count))
    size = np.maximum(sizes[drawn].sum(axis=1), 1)
    gaps = np.sqrt(sums[:, drawn].sum(axis=2) / size) / max(floor, 1e-9)
    values = [closure(b, a) for b, a in gaps.T]
    low, high = np.percentile(values, (5, 95))
    return float(low), float(high)
