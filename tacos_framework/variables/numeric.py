"""Variables that are numbers between two bounds."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tacos_framework.variables.gene import Gene

LARGEST_INTEGER = 2**53
"""Beyond it, whole numbers are no longer told apart as float64 genes."""


@dataclass(frozen=True)
class Continuous:
    """Any number between two bounds, both included."""

    name: str
    lower: float
    upper: float
    unit: str = "1"

    def __post_init__(self) -> None:
        _check_bounds(self)

    @property
    def genes(self) -> tuple[Gene, ...]:
        return (Gene(self.name, self.name, "continuous", float(self.lower), float(self.upper)),)

    def decode(self, genes: Sequence[float]) -> tuple[float, tuple[float, ...]]:
        value = float(genes[0]) + 0.0  # -0.0 becomes 0.0, so that equal candidates have equal keys
        return value, (value,)

    def encode(self, value: Any) -> tuple[float, ...]:
        _check_inside(self, value)
        return (float(value),)

    def draw(self, rng: np.random.Generator) -> tuple[float, ...]:
        return (rng.uniform(self.lower, self.upper),)

    def as_data(self) -> dict[str, Any]:
        bounds = {"lower": self.lower, "upper": self.upper}
        return {"name": self.name, "kind": "continuous", "unit": self.unit, **bounds}


@dataclass(frozen=True)
class Integer:
    """Any whole number between two bounds, both included."""

    name: str
    lower: int
    upper: int
    unit: str = "1"

    def __post_init__(self) -> None:
        _check_bounds(self)
        for bound in (self.lower, self.upper):
            if bound != int(bound) or abs(bound) > LARGEST_INTEGER:
                raise ValueError(f"{self.name} is a whole number, so its bounds are, not {bound}")

    @property
    def genes(self) -> tuple[Gene, ...]:
        return (Gene(self.name, self.name, "integer", float(self.lower), float(self.upper)),)

    def decode(self, genes: Sequence[float]) -> tuple[int, tuple[float, ...]]:
        """The nearest whole number."""
        value = round(float(genes[0]))
        return value, (float(value),)

    def encode(self, value: Any) -> tuple[float, ...]:
        _check_inside(self, value)
        if value != int(value):
            raise ValueError(f"{self.name} is a whole number, not {value}")
        return (float(value),)

    def draw(self, rng: np.random.Generator) -> tuple[float, ...]:
        return (float(rng.integers(int(self.lower), int(self.upper), endpoint=True)),)

    def as_data(self) -> dict[str, Any]:
        bounds = {"lower": self.lower, "upper": self.upper}
        return {"name": self.name, "kind": "integer", "unit": self.unit, **bounds}


def _check_bounds(variable: Continuous | Integer) -> None:
    lower, upper = variable.lower, variable.upper
    if not (math.isfinite(lower) and math.isfinite(upper)):
        raise ValueError(f"bounds of {variable.name} must be finite numbers, not {lower} and {upper}")
    if not lower < upper:
        raise ValueError(f"{variable.name} is between {lower} and {upper}: the lower bound must come first")


def _check_inside(variable: Continuous | Integer, value: Any) -> None:
    if isinstance(value, bool) or not isinstance(value, int | float | np.integer | np.floating):
        raise ValueError(f"{variable.name} is a number, not {value!r}")
    if not variable.lower <= value <= variable.upper:
        unit = "" if variable.unit == "1" else f" {variable.unit}"
        raise ValueError(
            f"{variable.name} is {value}{unit}, outside of {variable.lower} to {variable.upper}{unit}"
        )
