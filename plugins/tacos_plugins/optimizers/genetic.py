"""The paper's genetic algorithm."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, ClassVar, Literal

import numpy as np
from pydantic import model_validator

from tacos_framework import (
    Candidate,
    DesignSpace,
    Evaluated,
    Fault,
    Gene,
    Settings,
    UserError,
    did_you_mean,
    setting,
)
from tacos_plugins.optimizers.short_searches import spread_only


class Genetic:
    """Elites, uniform crossover among the best, then a random factor and a random offset per gene.

    Each generation holds ``population`` candidates. The ``keep`` best go on unchanged, and are asked again
    so that the study can score them on the generation's own episodes. The others are offspring: each gene
    is taken from a random one of the ``parents`` best, then mutated,

        x' = x U(factor) + U(-add, add),

    clipped to its bounds and snapped to what can be manufactured. Genes that choose among values (catalog
    rows, categories) have no scale a factor could act on: they are drawn anew, or take a step in the order
    of their values. Candidates that failed never breed; where all failed, the next generation starts over.
    Equal candidates count once among elites and parents.

    Source: the paper, Sec. 4.2, 4.3 and supplement, "Genetic Algorithm Implementation"; Holland 1992,
    "Adaptation in natural and artificial systems". Defaults are those of the monocular study.

    >>> from tacos_framework.variables.design_space import Continuous
    >>> space = DesignSpace([Continuous("hfov_deg", 50, 120, "deg"), Continuous("baseline_m", 0.01, 3, "m")])
    >>> config = Genetic.Config(
    ...     population=5, keep=2, parents=3, generations=40, add={"hfov_deg": 5, "baseline_m": 0.2}
    ... )
    >>> search, best = Genetic(config, space=space, rng=np.random.default_rng(1)), -np.inf
    >>> while not (reason := search.stop()):
    ...     observed = [Evaluated(c, -abs(c.values["baseline_m"] - 1.6)) for c in search.ask()]
    ...     best = max(best, *(result.fitness for result in observed))
    ...     search.tell(observed)
    >>> reason, bool(best > -0.1)
    ('all 40 generations were evaluated', True)
    """

    budget: ClassVar[str] = "generations"

    class Config(Settings):
        population: int = setting(10, help="Candidates per generation.", ge=1)
        keep: int = setting(3, help="Best candidates that go on unchanged.", ge=0)
        parents: int = setting(5, help="Best candidates that breed.", ge=1)
        generations: int = setting(
            20, help="Generations evaluated in all.", ge=1, also=("budget", "iterations", "steps")
        )
        factor: tuple[float, float] = setting(
            (0.8, 1.2), help="Range of the random factor on each gene of an offspring."
        )
        add: float | dict[str, float] = setting(
            3.0,
            help=(
                "Largest random offset on each gene of an offspring, in the gene's own unit: one number for "
                "all, or one for each variable (sensor) or gene (sensor.pixel_um)."
            ),
        )
        mutation_rate: float = setting(
            1.0, help="Probability that a gene of an offspring is mutated.", ge=0, le=1
        )
        discrete_mutation: Literal["step", "redraw"] = setting(
            "step",
            help=(
                "Mutation of a choice among values: 'step' moves its position in the list by up to "
                "discrete_step, 'redraw' draws any value; with redraw choose a mutation_rate well below 1, "
                "or nothing of the choice is inherited."
            ),
        )
        discrete_step: float = setting(
            3.0, help="Largest step of a choice in the list of its values.", unit="positions", ge=0
        )
        start: Literal["random", "smallest", "largest"] = setting(
            "random", help="First generation: random, or all genes at their smallest or largest value."
        )

        @model_validator(mode="after")
        def _fits_together(self) -> Genetic.Config:
            for name in ("keep", "parents"):
                if getattr(self, name) > self.population:
                    raise ValueError(f"{name}={getattr(self, name)} of a population of {self.population}")
            if self.keep == self.population and self.generations > 1:
                raise ValueError(f"keep={self.keep} leaves no room for offspring in {self.population}")
            if self.factor[0] > self.factor[1]:
                raise ValueError(f"factor must rise, not {list(self.factor)}")
            offsets = self.add.values() if isinstance(self.add, dict) else [self.add]
            if min(offsets, default=0.0) < 0:
                raise ValueError(f"add must be 0 or more, not {self.add}")
            return self

    def __init__(self, config: Config, *, space: DesignSpace, rng: np.random.Generator) -> None:
        self.config = config
        self._space = space
        self._rng = rng
        self._add = _offset_per_gene(config.add, space.genes)
        self._generations_observed = 0
        self._population = self._first_generation()

    @classmethod
    def notes(cls, config: Config, space: DesignSpace) -> Iterator[str]:
        """That nothing is bred, in a single generation."""
        if config.generations == 1:
            yield spread_only(config.population, config.population)

    @property
    def expected_candidates(self) -> int:
        return self.config.population * self.config.generations

    def ask(self) -> list[Candidate]:
        """The generation to evaluate, elites first; the same one until it is evaluated."""
        return list(self._population)

    def tell(self, evaluated: Sequence[Evaluated]) -> None:
        """Take in the generation's fitness and breed the next one.

        Raises `ValueError` when a fitness is NaN, which has no rank.
        """
        fitness: dict[Candidate, float] = {}  # equal candidates once, or elites would end as copies of one
        for result in evaluated:
            if result.fitness is None:
                continue
            if math.isnan(result.fitness):
                raise ValueError(f"the fitness of candidate {result.candidate.key} is not a number")
            fitness.setdefault(result.candidate, result.fitness)
        ranked = sorted(fitness, key=lambda candidate: -fitness[candidate])
        self._generations_observed += 1
        self._population = self._next_generation(ranked)  # after the last one too: a study may be extended

    def stop(self) -> str | None:
        """A reason once the last generation is observed."""
        if self._generations_observed < self.config.generations:
            return None
        return f"all {self.config.generations} generations were evaluated"

    def state(self) -> dict[str, Any]:
        """Progress, the generation in flight and the generator, as JSON values."""
        return {
            "generations_observed": self._generations_observed,
            "population": [list(candidate.genes) for candidate in self._population],
            "rng": self._rng.bit_generator.state,
        }

    def restore(self, state: dict[str, Any]) -> None:
        self._generations_observed = state["generations_observed"]
        self._population = [self._space.decode(genes) for genes in state["population"]]
        self._rng.bit_generator.state = state["rng"]

    def _first_generation(self) -> list[Candidate]:
        count = self.config.population
        if self.config.start == "random":
            return [self._space.sample(self._rng) for _ in range(count)]
        smallest = self.config.start == "smallest"
        return [
            self._space.decode([gene.lower if smallest else gene.upper for gene in self._space.genes])
        ] * count

    def _next_generation(self, ranked: Sequence[Candidate]) -> list[Candidate]:
        if not ranked:
            return self._first_generation()
        elites = list(ranked[: self.config.keep])
        parents = np.array([candidate.genes for candidate in ranked[: self.config.parents]])
        offspring = [self._offspring(parents) for _ in range(self.config.population - len(elites))]
        return elites + offspring

    def _offspring(self, parents: np.ndarray) -> Candidate:
        count = len(self._space.genes)
        chosen = self._rng.integers(len(parents), size=count)  # uniform crossover
        genes = parents[chosen, np.arange(count)]
        mutates = self._rng.random(count) < self.config.mutation_rate
        mutated = [self._mutate(i, value) for i, value in enumerate(genes)]
        return self._space.decode(np.where(mutates, mutated, genes))

    def _mutate(self, index: int, value: float) -> float:
        gene = self._space.genes[index]
        if gene.kind == "choice" and self.config.discrete_mutation == "redraw":
            return float(self._rng.integers(int(gene.lower), int(gene.upper), endpoint=True))
        if gene.kind == "choice":
            return value + self._rng.uniform(-1, 1) * self.config.discrete_step
        return value * self._rng.uniform(*self.config.factor) + self._rng.uniform(-1, 1) * self._add[index]


def _offset_per_gene(add: float | Mapping[str, float], genes: Sequence[Gene]) -> list[float]:
    """The largest offset of each gene; a gene's own entry goes before its variable's."""
    if not isinstance(add, Mapping):
        return [add] * len(genes)
    wanted = [gene for gene in genes if gene.kind != "choice"]
    known = {name for gene in wanted for name in (gene.name, gene.variable)}
    where = "optimizer.genetic"
    faults = [
        Fault(where, f"add names {name!r}, which is no number of the design", "", did_you_mean(name, known))
        for name in add
        if name not in known
    ]
    faults += [
        Fault(where, f"add has no entry for {gene.name!r}", "one per variable", f"Add {gene.variable!r}.")
        for gene in wanted
        if gene.name not in add and gene.variable not in add
    ]
    if faults:
        raise UserError(faults)
    return [add.get(gene.name, add.get(gene.variable, 0.0)) for gene in genes]
