"""Feasible cameras of a design space: every part of its catalogs, with optics spread evenly over the rest."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from tacos_framework import CatalogChoice, CatalogPart, Categorical, DesignSpace, Values, Variable

Parts = tuple[CatalogPart, ...]
"""One part of each catalog the design chooses from, in the order of its variables."""


@dataclass(frozen=True)
class Pool:
    """The cameras of a design space, by their parts and the rest as a row of the unit cube.

    >>> from tacos_framework.variables.design_space import Continuous
    >>> pool = Pool(DesignSpace([Continuous("pitch_deg", -30, 30, "deg")]))
    >>> pool.camera((), np.array([0.75]))
    {'pitch_deg': 15.0}
    """

    space: DesignSpace

    @property
    def catalogs(self) -> tuple[CatalogChoice, ...]:
        """The variables that are parts from a catalog."""
        return tuple(each for each in self.space.variables if isinstance(each, CatalogChoice))

    @property
    def parts(self) -> Iterator[Parts]:
        """All combinations of parts; one of none where there is no catalog."""
        return itertools.product(*(choice.rows for choice in self.catalogs))

    @property
    def dimensions(self) -> int:
        """Number of genes beside the parts."""
        return sum(len(each.genes) for each in self.space.variables if not isinstance(each, CatalogChoice))

    def camera(self, parts: Parts, unit: NDArray[np.float64]) -> dict[str, Any]:
        """Plain values of the camera of these parts.

        `parts`: one for each catalog. `unit`: (dimensions,) float64 in 0..1, of each other gene its place
        between its bounds.
        """
        own, rest = iter(parts), iter(unit)
        genes: list[float] = []
        for variable in self.space.variables:
            if isinstance(variable, CatalogChoice):
                genes.extend(variable.encode(next(own)))
            else:
                genes.extend(g.lower + next(rest) * (g.upper - g.lower) for g in variable.genes)
        return self.space.decode(genes).as_dict()

    def place(self, camera: Values) -> NDArray[np.float64]:
        """(dimensions,) where a camera of the space lies; the reverse of `camera`."""
        place: list[float] = []
        for variable in self.space.variables:
            if not isinstance(variable, CatalogChoice):
                genes = zip(variable.genes, variable.encode(camera[variable.name]), strict=True)
                place.extend((value - g.lower) / (g.upper - g.lower or 1.0) for g, value in genes)
        return np.clip(np.array(place, dtype=np.float64), 0.0, 1.0)

    def spread(self, count: int) -> NDArray[np.float64]:
        """(count, dimensions) places spread evenly, always the same."""
        if not self.dimensions:
            return np.zeros((1, 0))
        halton = qmc.Halton(self.dimensions, scramble=False)
        halton.fast_forward(1)  # the first is the corner
        return np.asarray(halton.random(count), dtype=np.float64)


def camera_at(variables: Sequence[Variable], places: Sequence[float] | NDArray[np.float64]) -> dict[str, Any]:
    """Plain values of a camera, from a place in 0..1 for each variable."""
    return {each.name: value_at(each, float(at)) for each, at in zip(variables, places, strict=True)}


def value_at(variable: Variable, at: float) -> Any:
    """The plain value of a variable at a place in 0..1; of choices and parts each has an equal share."""
    if isinstance(variable, CatalogChoice):
        return variable.rows[min(int(at * len(variable.rows)), len(variable.rows) - 1)].as_dict()
    if isinstance(variable, Categorical):
        return variable.values[min(int(at * len(variable.values)), len(variable.values) - 1)]
    gene = variable.genes[0]
    return variable.decode([gene.lower + at * (gene.upper - gene.lower)])[0]


def part_names(catalogs: Sequence[CatalogChoice], camera: Values) -> tuple[str, ...]:
    """The names of the parts of a camera, in the order of the catalogs; "?" for one without a name."""
    names = []
    for choice in catalogs:
        part = camera.get(choice.name)
        names.append(str(part.get("name", "?")) if isinstance(part, Mapping) else "?")
    return tuple(names)


def joined(names: Sequence[str]) -> str:
    """Everyday name of a combination of parts."""
    return " + ".join(names)
