"""Coordinates of scores, as rows of numbers between 0 and 1."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

NO_WIDTH = 1e-9
"""Ranges below this share of their values, or of one, are rounding errors."""


@dataclass(frozen=True)
class CoordinateSystem:
    """Names of coordinates, and the range of each that is scaled to 0..1.

    >>> system = CoordinateSystem.spanning([{"hfov_deg": 50.0, "pitch_deg": 0.0}, {"hfov_deg": 90.0}])
    >>> system.rows([{"hfov_deg": 60.0, "pitch_deg": 0.0}, {"hfov_deg": 90.0}]).tolist()
    [[0.25, 0.0], [1.0, nan]]
    """

    names: tuple[str, ...]
    """The coordinates, in the order of the columns."""
    lower: NDArray[np.float64]
    span: NDArray[np.float64]
    """(names,) smallest value of each and the width of its range, in its own unit."""

    @classmethod
    def spanning(cls, points: Sequence[Mapping[str, float]]) -> CoordinateSystem:
        """The coordinates of these points; a range of no width is scaled by one."""
        names = tuple(dict.fromkeys(name for point in points for name in point))
        table = _table(points, names)
        known = np.isfinite(table)
        lower = np.where(known, table, np.inf).min(axis=0, initial=np.inf)
        upper = np.where(known, table, -np.inf).max(axis=0, initial=-np.inf)
        seen = known.any(axis=0)
        lower, upper = np.where(seen, lower, 0.0), np.where(seen, upper, 0.0)
        wide = upper - lower > NO_WIDTH * np.maximum(1.0, np.abs(upper))
        return cls(names, lower, np.where(wide, upper - lower, 1.0))

    def with_range(self, name: str, lower: float, upper: float) -> CoordinateSystem:
        """The same and one more coordinate."""
        span = np.append(self.span, upper - lower)
        return CoordinateSystem((*self.names, name), np.append(self.lower, lower), span)

    def rows(self, points: Sequence[Mapping[str, float]]) -> NDArray[np.float64]:
        """(points, names) scaled coordinates; NaN where a point does not tell one."""
        return (_table(points, self.names) - self.lower) / self.span


def _table(points: Sequence[Mapping[str, float]], names: Sequence[str]) -> NDArray[np.float64]:
    rows = [[point.get(name, np.nan) for name in names] for point in points]
    table = np.array(rows, dtype=np.float64).reshape(len(points), len(names))
    return np.where(np.isfinite(table), table, np.nan)
