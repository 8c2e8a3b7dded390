"""Candidates that keep all constraints, spread over what images depend on."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain, islice, product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework import (
    Candidate,
    CatalogChoice,
    Categorical,
    Continuous,
    DesignProblem,
    DesignSpace,
    Gene,
    Integer,
    Variable,
)
from tacos_plugins.surrogate.warp import Warp

Array = NDArray[np.float64]
Own = tuple[float, ...]
"""The genes of one variable."""

MOST_COMBINATIONS = 256
"""Up to so many combinations of choices have as many candidates each; more are mixed, as they can be had."""

ATTEMPTS = 8
"""Most candidates drawn per candidate wanted, where few keep the constraints."""

MOST_VALUES = 32
"""Whole numbers with more values are drawn from their range, as if they were continuous, and rounded."""

SWEEP = 17
"""Places along a gene at which it is looked how coordinates change."""

REDRAWN = 0.25
"""Probability that a choice is drawn anew where candidates are drawn around one."""


@dataclass(frozen=True)
class PlacedCandidate:
    """A candidate, and what images of it depend on."""

    candidate: Candidate
    coordinates: Mapping[str, float]


class FeasibleCandidates:
    """The candidates of a design space that keep all constraints.

    - `coordinates`: what images depend on, by name, for a candidate that keeps all constraints.
    - `broken`: by how much a candidate breaks constraints; empty where it keeps all.
    """

    def __init__(
        self,
        space: DesignSpace,
        coordinates: Callable[[Candidate], Mapping[str, float]],
        broken: Callable[[Candidate], Mapping[str, float]],
    ) -> None:
        self.space = space
        self.coordinates = coordinates
        self._broken = broken

    @classmethod
    def of(cls, space: DesignSpace, problem: DesignProblem | None) -> FeasibleCandidates:
        """Those of a problem, or of the bare space where nothing more is known."""
        if problem is None:
            return cls(space, lambda candidate: bare_coordinates(space, candidate), lambda _: {})
        return cls(space, problem.coordinates, problem.broken)

    def placed(self, genes: Sequence[float] | Array) -> PlacedCandidate | None:
        """The candidate nearest to these genes; None where it breaks a constraint."""
        candidate = self.space.decode(genes)
        return None if self._broken(candidate) else PlacedCandidate(candidate, self.coordinates(candidate))

    def pool(self, count: int, rng: np.random.Generator) -> list[PlacedCandidate]:
        """About `count` candidates: all combinations of parts and choices, each with a spread of the rest.

        There are more where the combinations are more, fewer where constraints leave no room, and none where
        nothing that was drawn keeps them. Each candidate comes once.
        """
        if self._combinations <= MOST_COMBINATIONS:
            placed = self._evenly(count, rng)
        else:
            placed = islice(self._mixed(count, rng), count)
        return list({each.candidate: each for each in placed}.values())

    def most_broken(self, count: int, rng: np.random.Generator) -> str | None:
        """The constraint that most of `count` candidates drawn at random break; None where they keep all."""
        names = Counter(name for _ in range(count) for name in self._broken(self.space.sample(rng)))
        return names.most_common(1)[0][0] if names else None

    def around(
        self, centres: Sequence[Candidate], count: int, step: float, rng: np.random.Generator
    ) -> list[PlacedCandidate]:
        """At most `count` candidates near these, by turns.

        `count`: how many candidates to draw; those that break a constraint are left out. `step`: standard
        deviation of a step, in ranges of a variable.
        """
        found: dict[Candidate, PlacedCandidate] = {}
        for number in range(count if centres else 0):
            genes = list(centres[number % len(centres)].genes)
            for i in self._continuous:
                place = self._warps[i].place(genes[i]) + step * rng.standard_normal()
                genes[i] = self._warps[i].gene(float(np.clip(place, 0.0, 1.0)))
            for (_, first), values in zip(self._choices, self._values, strict=True):
                if rng.random() < REDRAWN:
                    own = values[rng.integers(len(values))]
                    genes[first : first + len(own)] = own
            if (placed := self.placed(genes)) is not None:
                found.setdefault(placed.candidate, placed)
        return list(found.values())

    @cached_property
    def _continuous(self) -> list[int]:
        """The numbers of the genes that are drawn from a range."""
        names = {variable.name for variable in self.space.variables if _has_range(variable)}
        return [i for i, gene in enumerate(self.space.genes) if gene.variable in names]

    @cached_property
    def _choices(self) -> list[tuple[Variable, int]]:
        """The other variables, each with the number of its first gene."""
        names = [gene.variable for gene in self.space.genes]
        others = [variable for variable in self.space.variables if not _has_range(variable)]
        return [(variable, names.index(variable.name)) for variable in others]

    @cached_property
    def _values(self) -> list[list[Own]]:
        """The genes of all values of each of the others."""
        return [_values_of(variable) for variable, _ in self._choices]

    @property
    def _combinations(self) -> int:
        return math.prod(map(len, self._values))

    def _evenly(self, count: int, rng: np.random.Generator) -> Iterator[PlacedCandidate]:
        """As many candidates of each combination that can be had."""
        combinations = list(product(*self._values))
        most = count if self._continuous else len(combinations)
        for _ in range(2):  # once more of those that can be had, where constraints leave few
            each = math.ceil(most / len(combinations))
            found = [self._of_combination(self._genes(own), each, rng) for own in combinations]
            yield from chain.from_iterable(found)
            most -= sum(map(len, found))
            combinations = [own for own, some in zip(combinations, found, strict=True) if some]
            if not combinations or most < count / 2:
                break

    def _mixed(self, count: int, rng: np.random.Generator) -> Iterator[PlacedCandidate]:
        """One candidate of a combination at a time: of all in turn where that takes few tries, or of any."""
        tries = ATTEMPTS * count
        every = list(product(*self._values)) if self._combinations <= tries else None
        tried = 0
        while tried < tries:
            if every is not None:
                batch = [every[i] for i in rng.permutation(len(every))]
            else:
                batch = list(zip(*(_shuffled(own, count, rng) for own in self._values), strict=True))
            for combination, places in zip(batch, self._places(len(batch), rng), strict=True):
                if (placed := self._at(self._genes(combination), places)) is not None:
                    yield placed
            tried += len(batch)

    def _genes(self, combination: Sequence[Own]) -> Array:
        """Genes with these choices; those drawn from a range are in the middle."""
        genes = self._middle.copy()
        for (_, first), own in zip(self._choices, combination, strict=True):
            genes[first : first + len(own)] = own
        return genes

    def _places(self, count: int, rng: np.random.Generator) -> Array:
        """(count, genes drawn from a range) places of a Latin hypercube."""
        from scipy.stats import qmc  # late: checking a recipe draws nothing

        return np.asarray(qmc.LatinHypercube(len(self._continuous), rng=rng).random(count))

    def _at(self, genes: Array, places: Array) -> PlacedCandidate | None:
        """The candidate with its numbers at these places between 0 and 1."""
        for i, place in zip(self._continuous, places, strict=True):
            genes[i] = self._warps[i].gene(place)
        return self.placed(genes)

    @property
    def _middle(self) -> Array:
        return np.array([(gene.lower + gene.upper) / 2 for gene in self.space.genes])

    def _of_combination(self, genes: Array, count: int, rng: np.random.Generator) -> list[PlacedCandidate]:
        """About `count` candidates of one combination, by Latin hypercubes."""
        found: list[PlacedCandidate] = []
        for _ in range(ATTEMPTS if self._continuous else 1):
            drawn = (self._at(genes.copy(), places) for places in self._places(count, rng))
            found.extend(placed for placed in drawn if placed is not None)
            if 2 * len(found) >= count:
                break
        return found[:count]

    @cached_property
    def _warps(self) -> dict[int, Warp]:
        """For each continuous gene where to draw it, so that coordinates come evenly."""
        middle = self.space.decode(self._middle)
        return {i: self._warp(i, self.space.genes[i], np.array(middle.genes)) for i in self._continuous}

    def _warp(self, index: int, gene: Gene, genes: Array) -> Warp:
        places = np.linspace(gene.lower, gene.upper, SWEEP)
        swept = []
        for place in places:
            genes[index] = place
            swept.append(self.placed(genes))
        return Warp.of_sweep(places, [None if s is None else s.coordinates for s in swept])


def bare_coordinates(space: DesignSpace, candidate: Candidate) -> dict[str, float]:
    """A candidate in numbers where no rig says what images depend on.

    Numbers are as they are, a part its design columns, and a choice without order one number for each value:
    1 for the chosen one.
    """
    found: dict[str, float] = {}
    for variable in space.variables:
        value: Any = candidate.values[variable.name]
        match variable:
            case CatalogChoice():
                columns = variable.design_columns
                found |= {f"{variable.name}.{column}": float(value.number(column)) for column in columns}
            case Categorical():
                found |= {f"{variable.name}={each}": float(each == value) for each in variable.values}
            case _:
                found[variable.name] = float(value)
    return found


def _shuffled(values: Sequence[Own], count: int, rng: np.random.Generator) -> list[Own]:
    """So many of these values in random order, each as often as any."""
    return [values[i % len(values)] for i in rng.permutation(count)]


def _has_range(variable: Variable) -> bool:
    """True if values are drawn from a range, rather than listed."""
    if isinstance(variable, Integer):
        return variable.upper - variable.lower >= MOST_VALUES
    return isinstance(variable, Continuous)


def _values_of(variable: Variable) -> list[Own]:
    """The genes of all values of a variable that is not continuous."""
    if isinstance(variable, CatalogChoice):
        return [variable.encode(row) for row in variable.rows]
    (gene,) = variable.genes
    return [(float(value),) for value in range(int(gene.lower), int(gene.upper) + 1)]
