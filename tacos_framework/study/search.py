"""One run of an optimizer over a design space: ask, simulate, train, score, tell."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

from tacos_framework.cache import content_key
from tacos_framework.contracts import Evaluated, Executor, State
from tacos_framework.plan import Plan
from tacos_framework.randomness import generator
from tacos_framework.simulation import EpisodeSpec, Evaluation, Evaluator, ScoreJob, state_key
from tacos_framework.study.asking import GuardedOptimizer
from tacos_framework.study.failing import FailuresInARow, KeepsFailing, limit_of
from tacos_framework.study.pipelined import score_pipelined
from tacos_framework.study.scoring import score_in_a_race
from tacos_framework.study.shards import score_sharded
from tacos_framework.variables.design_space import Candidate, DesignSpace

FINALISTS = 3
"""Candidates scored once more on common episodes where the search's own scores do not compare."""


@dataclass(frozen=True)
class CandidateStats:
    """What is remembered of a candidate over all generations it took part in."""

    values: Mapping[str, Any]
    fitness_sum: float
    times: int

    @property
    def mean_fitness(self) -> float:
        """Mean fitness over the generations it was scored in."""
        return self.fitness_sum / self.times


@dataclass
class Search:
    """The state of one search; `step` takes it one generation further.

    Parameters
    ----------
    name
        ``"designed"``, or the camera whose free variables are searched.
    plan
        The checked recipe.
    space
        The variables to search; None when nothing is free, and the fixed values are evaluated as they are.
    fixed
        Values of the other variables, plain.
    budget
        Evaluations after which it stops even if the optimizer would go on; None leaves it to the optimizer.
    states
        States of trainable tasks.
    """

    name: str
    plan: Plan
    space: DesignSpace | None
    fixed: Mapping[str, Any]
    budget: int | None
    states: dict[str, State] = field(default_factory=dict)
    generation: int = 0
    n_observed: int = 0
    evaluations: int = 0
    images: int = 0
    stopped: str | None = None
    finalists_rescored: bool = False
    trained_best: int = 0
    best: Evaluation | None = None
    failing: FailuresInARow = field(default_factory=FailuresInARow)
    candidate_stats: dict[str, CandidateStats] = field(default_factory=dict)
    cache: dict[str, Evaluation] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.optimizer: GuardedOptimizer | None = None
        if self.space is not None:
            rng = generator(self.plan.recipe.seed, "optimizer", self.name)
            self.optimizer = GuardedOptimizer(self.plan.optimizer, self.space, rng)

    # what is simulated ------------------------------------------------------------------------------------

    @property
    def _training(self) -> bool:
        trains = (self.plan.recipe.nodes[name].train for name in self.plan.trainable)
        return any(train is not None and train.weights != "frozen" for train in trains)

    @property
    def _weights(self) -> str:
        """How weights pass from candidate to candidate: shared, branched or frozen."""
        modes = {t.weights for n in self.plan.trainable if (t := self.plan.recipe.nodes[n].train) is not None}
        return next((mode for mode in ("shared", "branched") if mode in modes), "frozen")

    def _episodes(self, purpose: str) -> tuple[EpisodeSpec, ...]:
        recipe = self.plan.recipe
        era = self.generation if recipe.study.renew_episodes == "each_generation" else 0
        study = recipe.study
        return tuple(
            EpisodeSpec(recipe.seed, (purpose, era, i), block=(block, study.blocks))
            for block in range(study.blocks)  # every world early: those that race are compared in all
            for i in range(study.episodes)
        )

    def _training_episode(self, candidate: int) -> EpisodeSpec | None:
        """The episode a candidate, counted in its generation, trains on; None where no task is trained."""
        if not self._training:
            return None
        study, seed = self.plan.recipe.study, self.plan.recipe.seed
        match study.renew_training or study.renew_episodes:
            case "never":
                return EpisodeSpec(seed, ("train", 0, 0))
            case "each_generation":
                return EpisodeSpec(seed, ("train", self.generation, 0))
            case "each_candidate":
                return EpisodeSpec(seed, ("train", self.generation, candidate))

    @property
    def comparable(self) -> bool:
        """Whether fitness compares across generations: same episodes, same weights."""
        return self.plan.recipe.study.renew_episodes == "never" and not self._training

    def expected_candidates(self) -> int | None:
        """How many candidates are still to come, elites counted each time, if that is known."""
        if self.optimizer is None:
            return max(0, (self.budget or 1) - self.n_observed) if self._training else 1
        known = [n for n in (self.optimizer.expected_candidates, self.budget) if n is not None]
        return max(0, min(known) - self.n_observed) if known else None

    # one generation ---------------------------------------------------------------------------------------

    def step(
        self,
        executor: Executor,
        evaluate: Evaluator,
        on_evaluated: Callable[[Evaluation], None],
    ) -> list[Evaluation]:
        """Ask for candidates, evaluate them, tell; returns the evaluations, in the order asked.

        The search is changed only once all are there, so that a break in the middle loses this generation
        and nothing else.

        Raises
        ------
        KeepsFailing
            When candidates fail one after the other by the same defect of a component.
        """
        asked: list[Candidate] = self.optimizer.ask() if self.optimizer else []
        wanted = [{**self.fixed, **candidate.as_dict()} for candidate in asked]
        if self.optimizer is None:
            wanted = [dict(self.fixed)]
        elif not asked:
            self.stopped = self._stop()
            return []
        failing, seen = replace(self.failing), list[Evaluation]()
        limit = limit_of(None if self.generation else len(wanted))

        def see(evaluation: Evaluation) -> None:
            on_evaluated(evaluation)
            seen.append(evaluation)
            failing.saw(evaluation, limit)

        try:
            evaluations, states = self._evaluate(wanted, executor, evaluate, see)
        except KeepsFailing as error:
            error.evaluations = seen
            raise
        self.failing = failing
        if self.optimizer:
            self.optimizer.tell([Evaluated(c, e.fitness) for c, e in zip(asked, evaluations, strict=True)])
        self._remember(evaluations)
        self.states = states
        self.generation += 1
        self.stopped = self._stop()
        return evaluations

    def _stop(self) -> str | None:
        if self.optimizer is None:
            if self._training and self.evaluations < (self.budget or 1):
                return None  # its tasks train on it as long as they may on the others
            return "nothing is left free to search"
        if self.budget is not None and self.evaluations >= self.budget:
            return f"{self.evaluations} evaluations, the budget of {self.budget}, are spent"
        return self.optimizer.stop()

    def _evaluate(
        self,
        wanted: Sequence[dict[str, Any]],
        executor: Executor,
        evaluate: Evaluator,
        on_evaluated: Callable[[Evaluation], None],
    ) -> tuple[list[Evaluation], dict[str, State]]:
        episodes = self._episodes("design")
        jobs = [ScoreJob(v, episodes, self.states, self._training_episode(i)) for i, v in enumerate(wanted)]
        if self._training and self._weights == "shared":
            evaluations, states = [], dict(self.states)
            for evaluation in score_pipelined(jobs, self.plan.fitness, executor, evaluate):
                states.update(evaluation.states)
                evaluations.append(evaluation)
                on_evaluated(evaluation)
            return evaluations, states
        evaluations = self._cached_map(jobs, executor, evaluate, on_evaluated)
        states = dict(self.states)
        if self._training and (scored := [e for e in evaluations if e.fitness is not None]):
            states.update(max(scored, key=_fitness).states)
        return evaluations, states

    def _cached_map(
        self,
        wanted: Sequence[ScoreJob],
        executor: Executor,
        evaluate: Evaluator,
        on_evaluated: Callable[[Evaluation], None],
    ) -> list[Evaluation]:
        """Evaluate what has not been evaluated before in exactly this way, each thing once."""
        weights = state_key(self.states)
        keys = [_key(job, weights) for job in wanted]
        jobs = {key: job for key, job in zip(keys, wanted, strict=True) if key not in self.cache}
        fresh: dict[str, Evaluation] = {}
        for key, evaluation in zip(jobs, self._scored(jobs, keys, executor, evaluate), strict=True):
            fresh[key] = evaluation
            on_evaluated(evaluation)
        if self.comparable:  # otherwise no later generation can ask the same again
            known = {key: e for key, e in fresh.items() if e.raised is None}  # a defect may be mended
            self.cache.update({key: replace(e, states={}) for key, e in known.items()})
        evaluations, given = [], set()
        for key in keys:
            if key in fresh and key not in given:
                evaluations.append(fresh[key])
            else:
                again = replace(fresh.get(key) or self.cache[key], cached=True, images=0, seconds={})
                evaluations.append(again)
                on_evaluated(again)
            given.add(key)
        return evaluations

    def _scored(
        self, jobs: Mapping[str, ScoreJob], keys: Sequence[str], executor: Executor, evaluate: Evaluator
    ) -> Iterable[Evaluation]:
        """The evaluations of jobs, by a race where the recipe asks for one."""
        rules = self.plan.recipe.study.race
        if rules is None:
            return score_sharded(list(jobs.values()), self.plan.fitness, executor, evaluate)
        known = {key: self.cache[key] for key in keys if key in self.cache}
        if self.best is not None and self.comparable:
            known["best"] = self.best
        rivals = {key: e for key, e in known.items() if e.fitness is not None and e.dropped is None}
        return score_in_a_race(jobs, rivals, rules, self.plan.fitness, executor, evaluate)

    def _remember(self, evaluations: Sequence[Evaluation]) -> None:
        self.n_observed += len(evaluations)
        for evaluation in evaluations:
            self.evaluations += not evaluation.cached
            self.images += evaluation.images
            if evaluation.fitness is None:
                continue
            key = content_key(evaluation.values)
            old = self.candidate_stats.get(key, CandidateStats(evaluation.values, 0.0, 0))
            self.candidate_stats[key] = CandidateStats(
                old.values, old.fitness_sum + evaluation.fitness, old.times + 1
            )
            if evaluation.dropped is None and (self.best is None or evaluation.fitness > _fitness(self.best)):
                self.best = replace(evaluation, states={}, cached=False)

    def rescore_finalists(
        self, executor: Executor, evaluate: Evaluator, on_evaluated: Callable[[Evaluation], None]
    ) -> list[Evaluation]:
        """Where scores of different generations do not compare, score the best few on common episodes.

        Returns the evaluations; `best` is the winner.
        """
        self.finalists_rescored = True
        if self.comparable or len(self.candidate_stats) < 2:
            return []
        ranked = sorted(self.candidate_stats.values(), key=lambda stats: -stats.mean_fitness)[:FINALISTS]
        episodes = tuple(replace(spec, name=("final", *spec.name[1:])) for spec in self._episodes("final"))
        jobs = [ScoreJob(stats.values, episodes, self.states) for stats in ranked]
        evaluations = []
        for evaluation in score_sharded(jobs, self.plan.fitness, executor, evaluate):
            evaluations.append(evaluation)
            on_evaluated(evaluation)
        self.evaluations += len(evaluations)
        self.images += sum(evaluation.images for evaluation in evaluations)
        if scored := [e for e in evaluations if e.fitness is not None]:
            self.best = max(scored, key=_fitness)
        return evaluations

    # the network of the camera that was chosen ------------------------------------------------------------

    @property
    def rounds(self) -> int:
        """How often the states may have changed: generations, and trainings on the best."""
        return self.generation + self.trained_best

    def next_training_on_best(self) -> ScoreJob | None:
        """The next training on the best camera, if one is left."""
        if self.best is None or not self._training or self.trained_best >= self.plan.recipe.study.train_best:
            return None
        training = EpisodeSpec(self.plan.recipe.seed, ("train_best", self.trained_best))
        return ScoreJob(self.best.values, (), self.states, training, partial=True)

    def update_weights(self, evaluation: Evaluation) -> None:
        """Go on with the states a training job led to; one that failed leaves them as they are."""
        self.states = {**self.states, **evaluation.states}
        self.images += evaluation.images
        self.trained_best += 1

    # checkpoint -------------------------------------------------------------------------------------------

    def state(self) -> dict[str, Any]:
        """All that is needed to go on, as JSON values; states of tasks are kept apart."""
        return {
            "generation": self.generation,
            "n_observed": self.n_observed,
            "evaluations": self.evaluations,
            "images": self.images,
            "stopped": self.stopped,
            "finalists_rescored": self.finalists_rescored,
            "trained_best": self.trained_best,
            "best": self.best and as_data(self.best),
            "failing": asdict(self.failing),
            "candidate_stats": {key: asdict(stats) for key, stats in self.candidate_stats.items()},
            "cache": {key: as_data(evaluation) for key, evaluation in self.cache.items()},
            "optimizer": self.optimizer and self.optimizer.state(),
        }

    def restore(self, state: Mapping[str, Any], states: dict[str, State]) -> None:
        """Go on from a `state`."""
        self.generation = state["generation"]
        self.n_observed = state["n_observed"]
        self.evaluations = state["evaluations"]
        self.images = state["images"]
        self.stopped = state["stopped"]
        self.finalists_rescored = state["finalists_rescored"]
        self.trained_best = state["trained_best"]
        self.best = Evaluation(**state["best"]) if state["best"] else None
        self.candidate_stats = {
            key: CandidateStats(**stats) for key, stats in state["candidate_stats"].items()
        }
        self.cache = {key: Evaluation(**evaluation) for key, evaluation in state["cache"].items()}
        self.failing = FailuresInARow(**state["failing"])
        self.states = states
        if self.optimizer:
            self.optimizer.restore(state["optimizer"])


def _key(job: ScoreJob, weights: str) -> str:
    """Content key of a job that starts with weights of a given key."""
    specs = [asdict(spec) for spec in job.episodes]
    return content_key(job.values, specs, weights, job.training and asdict(job.training))


def as_data(evaluation: Evaluation) -> dict[str, Any]:
    """An evaluation as plain data, without the states of tasks and the error that ended it."""
    data = asdict(replace(evaluation, states={}, raised=None))
    del data["states"], data["raised"]
    return data


def _fitness(evaluation: Evaluation) -> float:
    assert evaluation.fitness is not None
    return evaluation.fitness
