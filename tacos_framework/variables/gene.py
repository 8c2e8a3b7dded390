"""Genes, and what a design space asks of a variable."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, Protocol

import numpy as np


@dataclass(frozen=True)
class Gene:
    """One number an optimizer varies.

    Parameters
    ----------
    name
        The variable's name, followed by the column for catalog variables: ``sensor.pixel_um``.
    variable
        The variable it belongs to.
    kind
        ``continuous``; ``integer``; or ``choice``, an index 0, 1, ... ``upper``.
    lower, upper
        Bounds, both included, in the unit of the variable.
    """

    name: str
    variable: str
    kind: Literal["continuous", "integer", "choice"]
    lower: float
    upper: float


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
