"""Candidates, and where they lie among all others."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Candidate
from tacos_plugins.surrogate.candidates import FeasibleCandidates, PlacedCandidate
from tacos_plugins.surrogate.coordinates import CoordinateSystem

Array = NDArray[np.float64]
Genes = tuple[float, ...]

POOL = 1024
"""Candidates compared each round, all parts of a catalog among them; drawn once, in a tenth of a second."""


@dataclass(frozen=True, eq=False)
class Located:
    """Candidates, each once, and their coordinates."""

    candidates: tuple[Candidate, ...]
    rows: Array
    """(candidates, names) scaled coordinates."""

    def __len__(self) -> int:
        return len(self.candidates)

    def take(self, numbers: Iterable[int]) -> Located:
        chosen = np.fromiter(numbers, dtype=np.int64)
        return Located(tuple(self.candidates[i] for i in chosen), self.rows[chosen])

    def without(self, genes: Collection[Genes]) -> Located:
        """Those of other genes than these."""
        return self.take(i for i, candidate in enumerate(self.candidates) if candidate.genes not in genes)

    def joined(self, *others: Located) -> Located:
        candidates = [c for located in (self, *others) for c in located.candidates]
        numbers = {candidate: number for number, candidate in reversed(list(enumerate(candidates)))}
        rows = np.concatenate([located.rows for located in (self, *others)])
        return Located(tuple(candidates), rows).take(sorted(numbers.values()))


class Pool:
    """The candidates a search chooses from.

    - `feasible`: what keeps all constraints.
    - `seed`: of the candidates that are compared in all rounds.
    """

    def __init__(self, feasible: FeasibleCandidates, seed: int) -> None:
        self.feasible = feasible
        self.seed = seed
        self._coordinates: dict[Genes, Mapping[str, float]] = {}

    @cached_property
    def _placed(self) -> list[PlacedCandidate]:
        return self.feasible.pool(POOL, np.random.default_rng(self.seed))

    @cached_property
    def everywhere(self) -> Located:
        """The candidates of all rounds: all there are where they are few."""
        return self._located(self._placed)

    @cached_property
    def system(self) -> CoordinateSystem:
        """The coordinates and their ranges among these."""
        return CoordinateSystem.spanning([placed.coordinates for placed in self._placed])

    def others(self, rng: np.random.Generator) -> Located:
        """As many others; the same again where there are no others."""
        return self._located(self.feasible.pool(POOL, rng))

    def around(
        self, centres: Sequence[Candidate], count: int, step: float, rng: np.random.Generator
    ) -> Located:
        """Candidates near some; see `FeasibleCandidates.around`."""
        return self._located(self.feasible.around(centres, count, step, rng))

    def coordinates(self, genes: Genes) -> Mapping[str, float]:
        """The coordinates that images of a candidate depend on."""
        if genes not in self._coordinates:
            self._coordinates[genes] = self.feasible.coordinates(self.feasible.space.decode(genes))
        return self._coordinates[genes]

    def at(self, genes: Iterable[Genes]) -> Located:
        """The candidates of these genes, each once."""
        each = list(dict.fromkeys(genes))
        decode = self.feasible.space.decode
        return self._located([PlacedCandidate(decode(g), self.coordinates(g)) for g in each])

    def _located(self, placed: Sequence[PlacedCandidate]) -> Located:
        rows = self.system.rows([each.coordinates for each in placed])
        return Located(tuple(each.candidate for each in placed), rows)
