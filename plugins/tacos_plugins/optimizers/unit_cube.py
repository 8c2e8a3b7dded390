"""The design space as a unit cube: where methods that know nothing of units draw their points."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Candidate, CatalogChoice, DesignSpace


class UnitCube:
    """Maps [0, 1] per gene onto the genes of a space.

    Continuous genes fill the interval from their lower to their upper bound. Integers and choices each get an
    equal share of it, the first and the last as much as any other.

    >>> from tacos_framework.variables.design_space import Categorical, Continuous
    >>> lens = Categorical("lens", ("wide", "normal", "tele"))
    >>> cube = UnitCube(DesignSpace([Continuous("pitch_deg", -30, 30, "deg"), lens]))
    >>> cube.candidate(np.array([0.75, 0.3])).as_dict()
    {'pitch_deg': 15.0, 'lens': 'wide'}
    """

    def __init__(self, space: DesignSpace) -> None:
        self._space = space
        half = np.array([0.0 if gene.kind == "continuous" else 0.5 for gene in space.genes])
        self._lower = np.array([gene.lower for gene in space.genes]) - half
        self._span = np.array([gene.upper for gene in space.genes]) + half - self._lower
        self._last = np.array([gene.upper for gene in space.genes])

    @property
    def dimension(self) -> int:
        return len(self._span)

    def candidate(self, point: NDArray[np.float64]) -> Candidate:
        """The candidate at a point, (genes,) float64 in 0..1, snapped to what can be manufactured."""
        genes = self._lower + point * self._span
        for i, gene in enumerate(self._space.genes):
            if gene.kind != "continuous":  # the middle between two integers belongs to the upper one, always
                genes[i] = np.floor(genes[i] + 0.5)
        return self._space.decode(np.minimum(genes, self._last))

    def spacing(self) -> NDArray[np.float64]:
        """(genes,) float64: the typical distance to the next value in the cube; 0 for continuous variables.

        For a quantized catalog it is the median over parts of the distance to the nearest part, shared out
        evenly over its columns.
        """
        steps: list[float] = []
        for variable in self._space.variables:
            count = len(variable.genes)
            if isinstance(variable, CatalogChoice) and variable.scheme == "quantized":
                steps.extend([self._distance_of_parts(variable, len(steps))] * count)
            else:
                whole = [gene.kind != "continuous" for gene in variable.genes]
                spans = self._span[len(steps) : len(steps) + count]
                steps.extend(
                    1.0 / span if is_whole else 0.0 for is_whole, span in zip(whole, spans, strict=True)
                )
        return np.array(steps)

    def _distance_of_parts(self, variable: CatalogChoice, first: int) -> float:
        spans = self._span[first : first + len(variable.genes)]
        usable = np.where(spans > 0, spans, 1.0)
        places = np.array([variable.encode(row) for row in variable.rows]) / usable
        if len(places) < 2:
            return 0.0
        distances = np.linalg.norm(places[:, None] - places[None], axis=2)
        np.fill_diagonal(distances, np.inf)
        return float(np.median(distances.min(axis=1)) / np.sqrt(len(spans)))
