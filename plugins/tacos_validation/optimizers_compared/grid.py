"""A design space on a grid, so that all that can be asked of it fits into a table."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

from tacos_framework import (
    Candidate,
    CatalogChoice,
    Categorical,
    Continuous,
    DesignSpace,
    Fault,
    Integer,
    UserError,
    Variable,
    did_you_mean,
)

DIGITS = 9
"""Decimals of a value on the grid, so that one point is one number however it was reached."""


@dataclass(frozen=True)
class Stepped(Continuous):
    """A number between two bounds that can be had in steps; the last may lie short of the upper bound.

    >>> Stepped("pitch_deg", -30, 30, "deg", step=4).decode([7.3])
    (6.0, (6.0,))
    """

    step: float = 1.0

    @property
    def points(self) -> tuple[float, ...]:
        last = math.floor((self.upper - self.lower) / self.step + 1e-9)
        return tuple(self._point(place) for place in range(last + 1))

    def decode(self, genes: Sequence[float]) -> tuple[float, tuple[float, ...]]:
        last = math.floor((self.upper - self.lower) / self.step + 1e-9)
        value = self._point(min(max(round((float(genes[0]) - self.lower) / self.step), 0), last))
        return value, (value,)

    def encode(self, value: Any) -> tuple[float, ...]:
        """The value itself; ValueError where it lies between two steps."""
        (gene,) = super().encode(value)
        if abs(self.decode((gene,))[0] - gene) > 10**-DIGITS:
            raise ValueError(f"{self.name} can be had in steps of {self.step:g}, so not as {value}")
        return (gene,)

    def _point(self, place: int) -> float:
        return round(self.lower + place * self.step, DIGITS) + 0.0


def on_grid(space: DesignSpace, steps: Mapping[str, float]) -> DesignSpace:
    """The space with every variable between bounds in steps.

    Raises UserError when a variable has no step, or a step no variable; all at once.
    """
    continuous = {each.name: each for each in space.variables if type(each) is Continuous}
    faults = [
        Fault(
            f"grid.{name}",
            f"there is no variable {name!r} between bounds",
            "",
            did_you_mean(name, continuous),
        )
        for name in steps
        if name not in continuous
    ] + [
        Fault("grid", f"{name} has no step", "one for each variable between bounds", f"Give grid.{name}.")
        for name in continuous
        if name not in steps
    ]
    if faults:
        raise UserError(faults)

    def stepped(variable: Variable) -> Variable:
        if not isinstance(variable, Continuous):
            return variable
        step = steps[variable.name]
        return Stepped(variable.name, variable.lower, variable.upper, variable.unit, step)

    return DesignSpace(stepped(variable) for variable in space.variables)


def coarse_grid(space: DesignSpace, steps: Mapping[str, float]) -> Iterator[Candidate]:
    """Every value of every choice at every point of a coarser grid, which starts at the lower bounds.

    `steps`: the coarse step of each variable between bounds; four fine ones where absent.
    """
    for values in product(*(_coarse_values(variable, steps) for variable in space.variables)):
        given = dict(zip(space.names, values, strict=True))
        yield space.decode(space.encode(given))


def count_coarse(space: DesignSpace, steps: Mapping[str, float]) -> int:
    return math.prod(len(_coarse_values(variable, steps)) for variable in space.variables)


def neighbours(space: DesignSpace, candidate: Candidate, strides: Mapping[str, int]) -> list[Candidate]:
    """The candidates one stride up or down from one, in each variable between bounds by itself.

    `strides`: steps of the fine grid in one stride of each variable.
    """
    found = {}
    for variable in space.variables:
        if isinstance(variable, Stepped):
            for sign in (-1, 1):
                moved = candidate.values[variable.name] + sign * strides[variable.name] * variable.step
                value, _ = variable.decode((moved,))
                other = space.decode(space.encode({**candidate.values, variable.name: value}))
                found[other.key] = other
    found.pop(candidate.key, None)
    return list(found.values())


def _coarse_values(variable: Variable, steps: Mapping[str, float]) -> Sequence[Any]:
    match variable:
        case Stepped():
            return variable.points[:: stride(variable, steps)]
        case CatalogChoice():
            return variable.rows
        case Categorical():
            return variable.values
        case Integer():
            return range(int(variable.lower), int(variable.upper) + 1)
        case _:
            raise UserError(Fault("grid", f"{variable.name} is of a kind that no grid can be made of"))


def stride(variable: Stepped, steps: Mapping[str, float]) -> int:
    """Fine steps in one coarse step of a variable; at least one."""
    return max(1, round(steps.get(variable.name, 4 * variable.step) / variable.step))
