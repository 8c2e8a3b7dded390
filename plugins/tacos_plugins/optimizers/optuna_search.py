"""The samplers of Optuna: tree-structured Parzen estimators and Gaussian processes."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np

from tacos_framework import (
    Candidate,
    Categorical,
    DesignProblem,
    DesignSpace,
    Evaluated,
    Fault,
    Settings,
    UserError,
    setting,
)
from tacos_plugins.optimizers.observed_results import validate_results
from tacos_plugins.optimizers.short_searches import spread_only

if TYPE_CHECKING:
    import optuna


DRAWS = 256
"""Candidates drawn to find one that breaks no constraint."""


class OptunaSearch:
    """Asks a model of the fitness where the next candidate is most likely to be better.

    ``tpe`` models where good and bad candidates lie, all genes together; ``gp`` models the fitness as a
    Gaussian process, and takes the candidate of the largest log expected improvement. A Gaussian process
    needs few evaluations but some tenths of a second of thought for each, so it suits those that cost more.

    The model learns from the candidate that was simulated, snapped to what can be manufactured, not from the
    point that was proposed. A candidate that breaks a constraint is told as just that, and by how much in
    all. One that is known to break one before it is simulated is not asked: of `DRAWS` draws the nearest that
    breaks none is, and the model learns of both. Candidates that failed otherwise count as the worst fitness
    observed so far: where they lie is worth avoiding. Fitness is taken for noisy.

    Each round draws with a sampler of its own, seeded from the study's generator. What is observed is then
    all there is to remember, and a resumed search goes on exactly as an unbroken one, without thinking it all
    through again.

    Sources: Akiba et al. 2019, "Optuna"; Bergstra et al. 2011, "Algorithms for hyper-parameter optimization"
    (tpe); Ament et al. 2023, "Unexpected improvements to expected improvement" (gp).

    >>> from tacos_framework.variables.design_space import Continuous
    >>> space = DesignSpace([Continuous("baseline_m", 0.01, 3, "m")])
    >>> config = OptunaSearch.Config(evaluations=40)
    >>> search, best = OptunaSearch(config, space=space, rng=np.random.default_rng(1)), -np.inf
    >>> while not (reason := search.stop()):
    ...     observed = [Evaluated(c, -abs(c.values["baseline_m"] - 1.6)) for c in search.ask()]
    ...     best = max(best, *(result.fitness for result in observed))
    ...     search.tell(observed)
    >>> reason, bool(best > -0.1)
    ('all 40 candidates were evaluated', True)
    """

    budget: ClassVar[str] = "evaluations"

    class Config(Settings):
        sampler: Literal["tpe", "gp"] = setting(
            "tpe", help="Parzen estimators (tpe), or a Gaussian process (gp), which needs torch installed."
        )
        evaluations: int = setting(
            200, help="Candidates asked in all.", ge=1, also=("budget", "trials", "iterations", "steps")
        )
        batch: int = setting(
            1,
            help="Candidates asked at a time; more keep workers busy, but learn nothing from one another.",
            ge=1,
        )
        initial: int = setting(10, help="Candidates drawn at random before the model is asked.", ge=1)

    def __init__(
        self,
        config: Config,
        *,
        space: DesignSpace,
        rng: np.random.Generator,
        problem: DesignProblem | None = None,
    ) -> None:
        if config.sampler == "gp" and find_spec("torch") is None:
            raise UserError(
                Fault("optimizer.optuna", "sampler gp needs torch", "", "Install torch, or use sampler tpe.")
            )
        self.config = config
        self._space = space
        self._rng = rng
        self._problem = problem
        self._distributions = _distributions_of(space)
        self._begin([])

    @classmethod
    def notes(cls, config: Config, space: DesignSpace) -> Iterator[str]:
        """That nothing is learnt, where all evaluations are drawn at random."""
        if config.evaluations <= config.initial:
            yield spread_only(config.evaluations, config.initial)

    def _begin(self, observed: Sequence[Mapping[str, Any]]) -> None:
        import optuna

        with _quiet():
            self._study = optuna.create_study(direction="maximize")
        self._constrained = any(entry["broken"] for entry in observed)
        self._observed: list[Mapping[str, Any]] = []
        for entry in observed:
            self._add(entry)
        self._next_round()

    def _next_round(self) -> None:
        self._round_seed = int(self._rng.integers(2**32))
        self._trials: list[optuna.trial.Trial] = []
        self._asked: list[Candidate] = []
        self._refused: list[Candidate] = []

    @property
    def expected_candidates(self) -> int:
        return self.config.evaluations

    def ask(self) -> list[Candidate]:
        if not self._asked:
            rng = np.random.default_rng(self._round_seed)
            count = min(self.config.batch, self.config.evaluations - self._evaluated)
            with _quiet():
                self._study.sampler = self._sampler()
                self._trials = [self._study.ask(self._distributions) for _ in range(count)]
            for trial in self._trials:
                proposed = self._space.decode([trial.params[gene.name] for gene in self._space.genes])
                possible = self._possible(proposed, rng)
                if possible != proposed:
                    self._refused.append(proposed)
                self._asked.append(possible)
        return list(self._asked)

    def _possible(self, proposed: Candidate, rng: np.random.Generator) -> Candidate:
        """The candidate, or the nearest of some draws that breaks no constraint where this one does."""
        if self._problem is None or not self._problem.broken(proposed):
            return proposed
        draws = [self._space.sample(rng) for _ in range(DRAWS)]
        possible = [candidate for candidate in draws if not self._problem.broken(candidate)]
        spans = [max(gene.upper - gene.lower, np.finfo(float).tiny) for gene in self._space.genes]

        def distance(candidate: Candidate) -> float:
            return float(np.linalg.norm(np.subtract(candidate.genes, proposed.genes) / spans))

        return min(possible, key=distance, default=proposed)

    def tell(self, evaluated: Sequence[Evaluated]) -> None:
        """Take in the fitness of the batch, and what it breaks.

        Raises `ValueError` when a fitness is NaN or infinite, or the results are not those of the candidates
        asked.
        """
        from optuna.trial import TrialState

        validate_results(evaluated, self._asked)
        with _quiet():
            for trial in self._trials:  # what it proposed is not what was simulated
                self._study.tell(trial, state=TrialState.FAIL)
        refused = [
            {"genes": list(c.genes), "fitness": None, "broken": self._excess(c), "asked": False}
            for c in self._refused
        ]
        results = [
            {
                "genes": list(result.candidate.genes),
                "fitness": result.fitness,
                "broken": math.fsum(result.broken.values()),
                "asked": True,
            }
            for result in evaluated
        ]
        found = [*refused, *results]
        if not self._constrained and any(entry["broken"] for entry in found):
            self._begin([*self._observed, *found])  # a model of the constraint needs it of all
            return
        for entry in found:
            self._add(entry)
        self._next_round()

    def _excess(self, candidate: Candidate) -> float:
        assert self._problem is not None
        return math.fsum(self._problem.broken(candidate).values())

    @property
    def _evaluated(self) -> int:
        """Number of candidates asked and evaluated."""
        return sum(entry["asked"] for entry in self._observed)

    def stop(self) -> str | None:
        """A reason once all evaluations are observed."""
        if self._evaluated < self.config.evaluations:
            return None
        return f"all {self.config.evaluations} candidates were evaluated"

    def state(self) -> dict[str, Any]:
        """The observations, the seed of the round in flight and the generator, as JSON values."""
        return {
            "observed": list(self._observed),
            "round_seed": self._round_seed,
            "rng": self._rng.bit_generator.state,
        }

    def restore(self, state: dict[str, Any]) -> None:
        self._begin(state["observed"])
        self._round_seed = state["round_seed"]
        self._rng.bit_generator.state = state["rng"]

    def _add(self, entry: Mapping[str, Any]) -> None:
        """Let the model know of a result."""
        import optuna

        genes = zip(self._space.genes, entry["genes"], strict=True)
        params = {gene.name: value if gene.kind == "continuous" else int(value) for gene, value in genes}
        with _quiet():
            trial = optuna.trial.create_trial(
                params=params,
                distributions=self._distributions,
                constraints={"broken": entry["broken"]} if self._constrained else None,
                **self._outcome(entry),
            )
            self._study.add_trial(trial)
        self._observed.append(entry)

    def _outcome(self, entry: Mapping[str, Any]) -> dict[str, Any]:
        """The fitness a result enters the model with, or that it enters without one.

        What failed counts as the worst so far. What breaks a constraint says nothing of the fitness: it has
        the mean, as samplers that model the constraint take no trial without a fitness.
        """
        from optuna.trial import TrialState

        known = [e["fitness"] for e in (*self._observed, entry) if e["fitness"] is not None]
        if not known:
            return {"state": TrialState.PRUNED if entry["broken"] else TrialState.FAIL}
        value = entry["fitness"]
        if value is None:
            value = float(np.mean(known)) if entry["broken"] else min(known)
        return {"state": TrialState.COMPLETE, "value": value}

    def _sampler(self) -> optuna.samplers.BaseSampler:
        from optuna.samplers import GPSampler, TPESampler

        if self.config.sampler == "gp":
            return GPSampler(seed=self._round_seed, n_startup_trials=self.config.initial)
        return TPESampler(
            seed=self._round_seed,
            n_startup_trials=self.config.initial,
            multivariate=True,
            constant_liar=self.config.batch > 1,
        )


def _distributions_of(space: DesignSpace) -> dict[str, Any]:
    """Optuna's description of each gene; values without an order are described as such."""
    from optuna.distributions import CategoricalDistribution, FloatDistribution, IntDistribution

    unordered = {variable.name for variable in space.variables if isinstance(variable, Categorical)}
    found: dict[str, Any] = {}
    for gene in space.genes:
        if gene.variable in unordered:
            found[gene.name] = CategoricalDistribution(range(int(gene.upper) + 1))
        elif gene.kind == "continuous":
            found[gene.name] = FloatDistribution(gene.lower, gene.upper)
        else:
            found[gene.name] = IntDistribution(int(gene.lower), int(gene.upper))
    return found


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep Optuna's log of every trial, and its notes that a sampler is new, from the user of a study."""
    import optuna

    verbosity = optuna.logging.get_verbosity()
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
            yield
    finally:
        optuna.logging.set_verbosity(verbosity)
