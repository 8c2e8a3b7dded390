"""A variable that is one of some values without order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tacos_framework.variables.gene import Gene


@dataclass(frozen=True)
class Categorical:
    """One of some values without order; text, numbers or booleans."""

    name: str
    values: tuple[Any, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "values", tuple(self.values))
        if not self.values:
            raise ValueError(f"{self.name} needs at least one value to choose from")
        tagged = [_tagged(value) for value in self.values]
        if repeated := sorted({repr(value) for value in self.values if tagged.count(_tagged(value)) > 1}):
            raise ValueError(f"{self.name} names {', '.join(repeated)} more than once")

    @property
    def genes(self) -> tuple[Gene, ...]:
        return (Gene(self.name, self.name, "choice", 0.0, float(len(self.values) - 1)),)

    def decode(self, genes: Sequence[float]) -> tuple[Any, tuple[float, ...]]:
        """The value of the nearest index."""
        index = round(float(genes[0]))
        return self.values[index], (float(index),)

    def encode(self, value: Any) -> tuple[float, ...]:
        """The index of the value; the boolean True and the number 1 are different values."""
        tagged = [_tagged(known) for known in self.values]
        if _tagged(value) not in tagged:
            raise ValueError(f"{self.name} is one of {', '.join(map(repr, self.values))}, not {value!r}")
        return (float(tagged.index(_tagged(value))),)

    def draw(self, rng: np.random.Generator) -> tuple[float, ...]:
        return (float(rng.integers(len(self.values))),)

    def as_data(self) -> dict[str, Any]:
        return {"name": self.name, "kind": "categorical", "unit": "", "values": list(self.values)}


def _tagged(value: Any) -> tuple[bool, Any]:
    """Tells booleans from the numbers they equal."""
    return isinstance(value, bool), value
