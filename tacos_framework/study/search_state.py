"""State of a search: findings, cost and position; kept in checkpoints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

from tacos_framework.cache import content_key
from tacos_framework.contracts import State
from tacos_framework.plan import Plan
from tacos_framework.simulation import Evaluation
from tacos_framework.study.failure_policy import FailuresInARow, alike
from tacos_framework.study.kept_evaluation import as_data, evaluation_from
from tacos_framework.study.run_files import KeptSearch
from tacos_framework.variables.design_space import DesignSpace

_OWN_FORM = {"finalists", "best", "searched", "failing", "candidate_stats", "cache", "optimizer"}
"""Fields of a search that a checkpoint has in another form."""

_PLAIN_STATE = tuple(name for name in KeptSearch.model_fields if name not in _OWN_FORM)
"""Fields of a search that it does."""


@dataclass(frozen=True)
class CandidateStats:
    """Memory of a candidate over all generations it took part in."""

    values: Mapping[str, Any]
    fitness_sum: float
    times: int

    @property
    def mean_fitness(self) -> float:
        """Mean fitness over the generations it was scored in."""
        return self.fitness_sum / self.times


@dataclass(frozen=True)
class EndOfSearch:
    """Findings of a search before its most promising candidates were scored once more."""

    best: Evaluation | None
    evaluations: int
    images: int


@dataclass
class SearchState:
    """State of a search."""

    name: str
    """``"designed"``, or the camera whose free variables are searched."""
    plan: Plan
    space: DesignSpace | None
    """The variables to search; None when nothing is free, and the fixed values are evaluated as they are."""
    fixed: Mapping[str, Any]
    """Values of the other variables, plain."""
    budget: int | None
    """Evaluations after which it stops even if the optimizer would go on; None leaves it to the optimizer.
    Candidates that break a constraint are none.
    """
    states: dict[str, State] = field(default_factory=dict)
    generation: int = 0
    n_observed: int = 0
    evaluations: int = 0
    images: int = 0
    stopped: str | None = None
    partly_scored: bool = False
    """True if a candidate was scored on some of the episodes only."""
    broken_in_a_row: int = 0
    failed_alike: int = 0
    common_failure: str | None = None
    """Number of candidates in a row that failed for the same reason, as far as can be told, and the last
    reason.
    """
    last_failure: str | None = None
    """Why the last candidate that failed did, in a sentence."""
    finalists_rescored: bool = False
    finalists: list[Evaluation] = field(default_factory=list)
    """The candidates scored once more at the end, on episodes of their own."""
    trained_best: int = 0
    best: Evaluation | None = None
    searched: EndOfSearch | None = None
    """State before the finalists; None while the search goes on."""
    failing: FailuresInARow = field(default_factory=FailuresInARow)
    candidate_stats: dict[str, CandidateStats] = field(default_factory=dict)
    cache: dict[str, Evaluation] = field(default_factory=dict)

    # what follows from the recipe ---------------------------------------------------------------------------

    @property
    def training(self) -> bool:
        """True if tasks learn during the search."""
        trains = (self.plan.recipe.nodes[name].train for name in self.plan.trainable)
        return any(train is not None and train.weights != "frozen" for train in trains)

    @property
    def weights_mode(self) -> str:
        """The way in which weights pass from candidate to candidate: shared, branched or frozen."""
        modes = {t.weights for n in self.plan.trainable if (t := self.plan.recipe.nodes[n].train) is not None}
        return next((mode for mode in ("shared", "branched") if mode in modes), "frozen")

    @property
    def repeatable(self) -> bool:
        """True if a candidate gets the same scores in another generation: same episodes, same weights."""
        return self.plan.recipe.study.renew_episodes == "never" and not self.training

    @property
    def comparable(self) -> bool:
        """True if the fitness of all candidates compares: the same for all, and all episodes for each."""
        return self.repeatable and not self.partly_scored

    @property
    def rounds(self) -> int:
        """Number of times the states may have changed: generations, and trainings on the best."""
        return self.generation + self.trained_best

    # what came out -----------------------------------------------------------------------------------------

    def remember(self, evaluations: Sequence[Evaluation]) -> None:
        """Take in what came out for the candidates of a generation."""
        self.n_observed += len(evaluations)
        for evaluation in evaluations:
            self.evaluations += not (evaluation.cached or evaluation.broken)
            self.images += evaluation.images
            self.broken_in_a_row = self.broken_in_a_row + 1 if evaluation.broken else 0
            if evaluation.fitness is None:
                self.last_failure = evaluation.failed
                if not (evaluation.cached or evaluation.broken):
                    same = alike(evaluation.failed, self.common_failure)
                    self.failed_alike = self.failed_alike + 1 if same else 1
                    self.common_failure = evaluation.failed
                continue
            key = content_key(evaluation.values)
            old = self.candidate_stats.get(key, CandidateStats(evaluation.values, 0.0, 0))
            self.candidate_stats[key] = CandidateStats(
                old.values, old.fitness_sum + evaluation.fitness, old.times + 1
            )
            if self.best is None or evaluation.fitness > fitness_of(self.best):
                self.best = replace(evaluation, states={}, cached=False)

    # checkpoint -------------------------------------------------------------------------------------------

    def as_data(self) -> dict[str, Any]:
        """All of it as JSON values; states of tasks are kept apart."""
        return {
            **{name: getattr(self, name) for name in _PLAIN_STATE},
            "finalists": [as_data(evaluation) for evaluation in self.finalists],
            "best": self.best and as_data(self.best),
            "searched": self.searched
            and {**asdict(self.searched), "best": self.searched.best and as_data(self.searched.best)},
            "failing": asdict(self.failing),
            "candidate_stats": {key: asdict(stats) for key, stats in self.candidate_stats.items()},
            "cache": {key: as_data(evaluation) for key, evaluation in self.cache.items()},
        }

    def take_up(self, state: Mapping[str, Any], states: dict[str, State]) -> None:
        for name in _PLAIN_STATE:
            setattr(self, name, state[name])
        self.finalists = [evaluation_from(evaluation) for evaluation in state["finalists"]]
        self.best = _evaluation_or_none(state["best"])
        end = state["searched"]
        self.searched = end and EndOfSearch(**{**end, "best": _evaluation_or_none(end["best"])})
        self.candidate_stats = {
            key: CandidateStats(**stats) for key, stats in state["candidate_stats"].items()
        }
        self.cache = {key: evaluation_from(evaluation) for key, evaluation in state["cache"].items()}
        self.failing = FailuresInARow(**state["failing"])
        self.states = states


def _evaluation_or_none(data: Mapping[str, Any] | None) -> Evaluation | None:
    return evaluation_from(data) if data else None


def fitness_of(evaluation: Evaluation) -> float:
    assert evaluation.fitness is not None
    return evaluation.fitness
