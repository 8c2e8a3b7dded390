"""JSON as plain values of the kinds a report can show: what is of another kind counts as missing."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

Interval = tuple[float, float]


def finite(value: Any) -> float | None:
    """A finite number; None where it is anything else."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    return float(value) if math.isfinite(value) else None


def numbers(row: Any) -> dict[str, float]:
    """Those values of a mapping that are finite numbers."""
    pairs = ((str(name), finite(value)) for name, value in mapping(row).items())
    return {name: value for name, value in pairs if value is not None}


def interval(value: Any) -> Interval | None:
    """Two numbers, the lower first; None where it is anything else."""
    if not isinstance(value, list | tuple) or len(value) != 2:
        return None
    low, high = finite(value[0]), finite(value[1])
    return None if low is None or high is None else (min(low, high), max(low, high))


def text(value: Any) -> str:
    """A text; empty where it is anything else."""
    return value if isinstance(value, str) else ""


def showable(value: Any) -> bool:
    """True for text and finite numbers."""
    return bool(text(value)) or isinstance(value, bool) or finite(value) is not None


def texts(value: Any) -> tuple[str, ...]:
    return tuple(each for each in value if isinstance(each, str)) if isinstance(value, list | tuple) else ()


def mapping(value: Any) -> Mapping[str, Any]:
    """A mapping; empty where it is anything else."""
    return value if isinstance(value, Mapping) else {}


def rows(value: Any) -> Iterator[Mapping[str, Any]]:
    return (row for row in value if isinstance(row, Mapping)) if isinstance(value, list) else iter(())
