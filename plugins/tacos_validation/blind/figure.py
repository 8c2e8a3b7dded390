"""One figure of a check, with its interval and its goal."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Figure:
    name: str
    value: float  # NaN where there are no cases
    low: float  # of the 95 % interval
    high: float
    count: int
    goal: str = ""
    met: bool | None = None  # true if it is met; None without a goal or cases
    unit: str = "%"  # ``%`` for shares, else what follows the number

    def as_data(self) -> dict[str, Any]:
        """For ``result.json``; NaN becomes null."""
        return {
            key: None if isinstance(value, float) and math.isnan(value) else value
            for key, value in asdict(self).items()
        }


def interval(hits: int, count: int) -> tuple[float, float]:
    """95 % interval of a share (Clopper and Pearson 1934).

    >>> [round(end, 3) for end in interval(0, 60)]
    [0.0, 0.06]
    """
    from scipy.stats import beta

    if not count:
        return math.nan, math.nan
    low = 0.0 if hits == 0 else float(beta.ppf(0.025, hits, count - hits + 1))
    high = 1.0 if hits == count else float(beta.ppf(0.975, hits + 1, count - hits))
    return low, high


def share(
    name: str, cases: Iterable[bool], goal: str = "", meets: Callable[[float], bool] | None = None
) -> Figure:
    hits = list(cases)
    value = sum(hits) / len(hits) if hits else math.nan
    met = meets(value) if meets and hits else None
    return Figure(name, value, *interval(sum(hits), len(hits)), len(hits), goal, met)


def middle(
    name: str,
    values: Iterable[float],
    goal: str = "",
    meets: Callable[[float], bool] | None = None,
    unit: str = "%",
) -> Figure:
    """A median with its 95 % interval by order statistics."""
    ordered = np.sort(np.asarray(list(values), float))
    count = len(ordered)
    if not count:
        return Figure(name, math.nan, math.nan, math.nan, 0, goal, None, unit)
    reach = 0.98 * math.sqrt(count)
    low, high = math.floor(count / 2 - reach), math.ceil(count / 2 + reach)
    value = float(np.median(ordered))
    ends = float(ordered[max(low, 0)]), float(ordered[min(high, count - 1)])
    return Figure(name, value, *ends, count, goal, meets(value) if meets else None, unit)


def at_least(least: float) -> Callable[[float], bool]:
    return lambda value: value >= least


def at_most(most: float) -> Callable[[float], bool]:
    return lambda value: value <= most
