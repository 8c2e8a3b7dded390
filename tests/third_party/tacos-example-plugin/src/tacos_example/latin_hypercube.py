"""One draw in each stratum of each gene."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from tacos_framework import Candidate, DesignSpace, Evaluated, Gene, Settings, setting


class LatinHypercube:
    """Cuts each gene into as many strata as there are evaluations, and draws once in each.

    The strata of the genes are paired at random. All is drawn at the beginning, so that nothing but the
    number of results observed so far has to be remembered beside it.

    Source: McKay, Beckman and Conover 1979, "A comparison of three methods for selecting values of input
    variables in the analysis of output from a computer code", Technometrics 21(2).
    """

    class Config(Settings):
        evaluations: int = setting(100, help="Candidates in all, and strata of each gene.", ge=1)
        batch: int = setting(10, help="Candidates asked at a time.", ge=1)

    def __init__(self, config: Config, *, space: DesignSpace, rng: np.random.Generator) -> None:
        self.config = config
        self._space = space
        self._n_observed = 0
        shares = latin_hypercube(config.evaluations, len(space.genes), rng)
        self._genes = [
            [value_at(gene, share) for gene, share in zip(space.genes, row, strict=True)] for row in shares
        ]

    @property
    def expected_candidates(self) -> int:
        return self.config.evaluations

    def ask(self) -> list[Candidate]:
        """The next batch; the same one until it is evaluated."""
        batch = self._genes[self._n_observed : self._n_observed + self.config.batch]
        return [self._space.decode(genes) for genes in batch]

    def tell(self, evaluated: Sequence[Evaluated]) -> None:
        """Count the results."""
        self._n_observed += len(evaluated)

    def stop(self) -> str | None:
        """A reason once all evaluations are observed."""
        return "every stratum was evaluated" if self._n_observed >= self.config.evaluations else None

    def state(self) -> dict[str, Any]:
        """The whole plan and how far it got, as JSON values."""
        return {"n_observed": self._n_observed, "genes": self._genes}

    def restore(self, state: dict[str, Any]) -> None:
        """Go on from a `state`."""
        self._n_observed, self._genes = state["n_observed"], state["genes"]


def latin_hypercube(count: int, genes: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """(count, genes) points in the unit cube, one in each stratum of each axis."""
    strata = np.column_stack([rng.permutation(count) for _ in range(genes)])
    return np.asarray((strata + rng.random((count, genes))) / count)


def value_at(gene: Gene, share: float) -> float:
    """The value at a share of a gene's range; whole numbers get equal shares."""
    if gene.kind == "continuous":
        return gene.lower + share * (gene.upper - gene.lower)
    return min(gene.lower + float(np.floor(share * (gene.upper - gene.lower + 1))), gene.upper)
