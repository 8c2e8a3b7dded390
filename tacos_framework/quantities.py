"""Quantities that a recipe bounds or aims at: derived by the rig, columns of parts, scores."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

Quantity = float | str | None
"""The value of a quantity; None where no source states it."""


def quantity(
    name: str,
    values: Mapping[str, Any],
    derived: Mapping[str, float],
    scores: Mapping[str, float] | None = None,
) -> Quantity:
    """The value of a quantity by its name; None where it is unknown.

    - `name`: ``hfov_deg``, derived by the rig; ``sensor.full_well_e``, a column of the part that is a
      variable's value; ``features.inliers``, a score.
    - `values`: plain values of the rig's variables, fixed ones among them; a part is a mapping of its
      columns.
    - `derived`: what the rig derives from them.
    - `scores`: mean scores and ``fitness``, where the candidate has been scored.
    """
    owner, dot, column = name.partition(".")
    part = values.get(owner)
    found = derived.get(name) if not dot else part.get(column) if isinstance(part, Mapping) else None
    return (scores or {}).get(name) if found is None else found


@dataclass(frozen=True)
class Breach:
    """A constraint that a candidate breaks."""

    quantity: str
    amount: float
    """By how much it is broken, above 0, in the unit of the quantity; 1 where that is no number."""
    sentence: str
    """The same for people."""
    known: bool = True
    """False where it is broken as nobody states the quantity."""


@dataclass(frozen=True)
class Constraint:
    """A bound on a quantity that candidates have to keep."""

    quantity: str
    """Its name, as :func:`quantity` takes it."""
    min: float | None = None
    max: float | None = None
    """Smallest and largest allowed value of a number."""
    any_of: tuple[str, ...] = ()
    """Allowed words. A text that lists several (``"C, CS"``) is each of them."""
    unknown: Literal["allow", "refuse"] = "allow"
    """Treatment of a candidate whose quantity is not stated."""
    because: str = ""
    """Why the constraint is there, where no recipe says it."""

    def __post_init__(self) -> None:
        if self.min is None and self.max is None and not self.any_of:
            raise ValueError(f"the constraint on {self.quantity} has no bound")
        if self.min is not None and self.max is not None and self.min > self.max:
            raise ValueError(f"the constraint on {self.quantity} has min {self.min:g} above max {self.max:g}")

    def breach(self, value: Quantity, part: str = "") -> Breach | None:
        """The way in which a value breaks the constraint; None if it keeps it. NaN breaks every bound.

        `part`: name of the part whose value it is, for the sentence.
        """
        name = f"{self.quantity} of {part}" if part else self.quantity
        why = f" ({self.because})" if self.because else ""
        if value is None:
            said = f"{name} is unknown, which the constraint refuses{why}"
            return Breach(self.quantity, 1.0, said, False) if self.unknown == "refuse" else None
        if isinstance(value, str):
            if not self.any_of or not set(self.any_of).isdisjoint(map(str.strip, value.split(","))):
                return None
            return Breach(self.quantity, 1.0, f"{name} is {value}, not {' or '.join(self.any_of)}{why}")
        found = f"{name} is {value:.6g}"
        if self.min is not None and not value >= self.min:
            said = f"{found}, below the smallest allowed value {self.min:.6g}{why}"
            return Breach(self.quantity, _finite(self.min - value), said)
        if self.max is not None and not value <= self.max:
            said = f"{found}, above the largest allowed value {self.max:.6g}{why}"
            return Breach(self.quantity, _finite(value - self.max), said)
        return None


def _finite(amount: float) -> float:
    return amount if math.isfinite(amount) else 1.0


@dataclass(frozen=True)
class Objective:
    """One of several aims that a front trades off against each other."""

    name: str
    """The quantity, as :func:`quantity` takes it; ``fitness`` for the weighted sum of scores."""
    unit: str
    aim: Literal["max", "min"]
    """Direction: much or little of it."""
