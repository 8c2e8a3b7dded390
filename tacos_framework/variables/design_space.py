"""The design space: which camera parameters vary, and between what.

A :class:`DesignSpace` is seen from two sides. The recipe and the report speak of *variables*
(``sensor = IMX178``); optimizers speak of *genes*, a flat vector of numbers in natural units. `decode` snaps
genes to what can be manufactured, so an optimizer may propose anything.

Catalog variables follow the two schemes of the paper (Sec. 3.3): ``discrete``, one gene that counts catalog
rows, and ``quantized``, one gene per numeric column and the nearest row afterwards (eq. 2).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework.errors import did_you_mean
from tacos_framework.values.candidate import Candidate
from tacos_framework.variables import CatalogChoice, Categorical, Continuous, Gene, Integer, Variable

__all__ = [
    "Candidate",
    "CatalogChoice",
    "Categorical",
    "Continuous",
    "DesignSpace",
    "Gene",
    "Integer",
    "Variable",
]


class DesignSpace:
    """The variables of a study, and the genes an optimizer sees.

    - `variables`: in the order in which their genes stand; none at all is allowed (a product that leaves
      nothing free).

    >>> lens = Categorical("lens", ("wide", "tele"))
    >>> space = DesignSpace([Continuous("focal_length_mm", 1, 20, "mm"), lens])
    >>> candidate = space.decode([30.0, 0.8])
    >>> candidate.as_dict()
    {'focal_length_mm': 20.0, 'lens': 'tele'}
    >>> candidate.genes
    (20.0, 1.0)
    """

    def __init__(self, variables: Iterable[Variable]):
        self.variables = tuple(variables)
        if len(set(self.names)) != len(self.names):
            raise ValueError(f"design variables need different names, not {', '.join(self.names)}")
        self.genes: tuple[Gene, ...] = tuple(gene for variable in self.variables for gene in variable.genes)
        self._lower = np.array([gene.lower for gene in self.genes])
        self._upper = np.array([gene.upper for gene in self.genes])

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(variable.name for variable in self.variables)

    def decode(self, genes: Sequence[float] | NDArray[np.float64]) -> Candidate:
        """The candidate nearest to these genes: clipped to the bounds, rounded, snapped to catalogs.

        Raises `ValueError` when there are too many or too few genes, or one is NaN.
        """
        given = np.asarray(genes, dtype=np.float64)
        if given.shape != (len(self.genes),):
            raise ValueError(f"this design space has {len(self.genes)} genes, not {given.shape}")
        if np.isnan(given).any():
            names = [gene.name for gene, value in zip(self.genes, given, strict=True) if np.isnan(value)]
            raise ValueError(f"not a number: {', '.join(names)}")
        rest = np.clip(given, self._lower, self._upper).tolist()
        values: dict[str, Any] = {}
        snapped: list[float] = []
        for variable in self.variables:
            count = len(variable.genes)
            values[variable.name], own = variable.decode(rest[:count])
            snapped.extend(own)
            rest = rest[count:]
        return Candidate(values, tuple(snapped))

    def encode(self, values: Mapping[str, Any]) -> NDArray[np.float64]:
        """(genes,) float64 of these values; ``decode(encode(values))`` has exactly these values.

        Parts may be given as `CatalogPart`, as their name, or as `Candidate.as_dict` gave them.

        Raises `ValueError` when a variable is missing, unknown, or cannot have its value.
        """
        self._check_names(values)
        if missing := [name for name in self.names if name not in values]:
            raise ValueError(f"no value for {', '.join(missing)}")
        genes = [gene for variable in self.variables for gene in variable.encode(values[variable.name])]
        return np.array(genes, dtype=np.float64)

    def sample(self, rng: np.random.Generator) -> Candidate:
        """A candidate drawn evenly over each variable.

        Quantized catalog variables are drawn in the box of their columns and snapped, as the paper's random
        start does: parts with few neighbours come more often.
        """
        return self.decode([gene for variable in self.variables for gene in variable.draw(rng)])

    def fix(self, values: Iterable[str]) -> DesignSpace:
        """The space without these variables, given by name or as a mapping of the values they are fixed at.

        The values need not lie in this space: a product may hold a sensor the catalog lacks.
        """
        fixed = set(values)
        self._check_names(fixed)
        return DesignSpace(variable for variable in self.variables if variable.name not in fixed)

    def as_data(self) -> list[dict[str, Any]]:
        """For each variable its name, kind, unit and what it may be, as JSON values."""
        return [variable.as_data() for variable in self.variables]

    def _check_names(self, names: Iterable[str]) -> None:
        for name in names:
            if name not in self.names:
                raise ValueError(f"{name!r} is no design variable. {did_you_mean(name, self.names)}".rstrip())
