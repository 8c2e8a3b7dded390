"""Genes, and what a design space asks of a variable."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, Protocol

import numpy as np


@dataclass(frozen=True)
class Gene:
    """One number an optimizer varies."""

    name: str
    """The variable's name, followed by the column for catalog variables: ``sensor.pixel_um``."""
    variable: str
    kind: Literal["continuous", "integer", "choice"]
    """``continuous``; ``integer``; or ``choice``, an index 0, 1, ... ``upper``."""
    lower: float
    upper: float
    """Bounds, both included, in the unit of the variable."""


class Variable(Protocol):
    """Requirements of the design space on a variable. Genes are its own, inside their bounds."""

    @property
    def name(self) -> str:
        """The name recipes use."""
        ...

    @property
    def genes(self) -> tuple[Gene, ...]:
        """The genes it needs."""
        ...

    def decode(self, genes: Sequence[float]) -> tuple[Any, tuple[float, ...]]:
        """The nearest value that can be manufactured, and the genes of exactly that value."""
        ...

    def encode(self, value: Any) -> tuple[float, ...]:
        """The genes of a value; ValueError for a value this variable cannot have."""
        ...

    def draw(self, rng: np.random.Generator) -> tuple[float, ...]:
        """Genes drawn at random, evenly over the variable."""
        ...

    def as_data(self) -> dict[str, Any]:
        """Name, kind, unit and what it may be, as JSON values for results and reports."""
        ...
