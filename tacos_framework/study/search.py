"""One run of an optimizer over a design space: ask, simulate, train, score, tell."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

from tacos_framework.cache import content_key
from tacos_framework.contracts import Asked, Executor, State
from tacos_framework.errors import Fault, UserError
from tacos_framework.plan import Plan
from tacos_framework.randomness import generator
from tacos_framework.simulation import EpisodeSpec, Evaluation, Evaluator, ScoreJob, state_key
from tacos_framework.study.asking import GuardedOptimizer, told_of
from tacos_framework.study.episodes import scored_episodes, training_episode
from tacos_framework.study.failing import FailuresInARow, KeepsFailing, limit_of
from tacos_framework.study.pipelined import score_pipelined
from tacos_framework.study.problem import design_problem
from tacos_framework.study.scoring import score_in_a_race
from tacos_framework.study.shards import score_sharded
from tacos_framework.variables.design_space import DesignSpace

MOST_BROKEN_IN_A_ROW = 1000
"""After so many candidates in a row that break a constraint, no more are asked for."""


_PLAIN_STATE = (
    "generation",
    "n_observed",
    "evaluations",
    "images",
    "stopped",
    "partly_scored",
    "broken_in_a_row",
    "last_failure",
    "finalists_rescored",
    "trained_best",
)
"""Fields of a search that a checkpoint has as they are."""


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
        Candidates that break a constraint are none.
    states
        States of trainable tasks.
    partly_scored
        Whether a candidate was scored on some of the episodes only.
    last_failure
        Why the last candidate that failed did, in a sentence.
    finalists
        The candidates scored once more at the end, on episodes of their own.
    design
        The search whose worlds its tasks train in; None for that search itself.
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
    partly_scored: bool = False
    broken_in_a_row: int = 0
    last_failure: str | None = None
    finalists_rescored: bool = False
    finalists: list[Evaluation] = field(default_factory=list)
    trained_best: int = 0
    best: Evaluation | None = None
    failing: FailuresInARow = field(default_factory=FailuresInARow)
    candidate_stats: dict[str, CandidateStats] = field(default_factory=dict)
    cache: dict[str, Evaluation] = field(default_factory=dict)
    design: Search | None = None

    def __post_init__(self) -> None:
        self.optimizer: GuardedOptimizer | None = None
        if self.space is not None:
            rng = generator(self.plan.recipe.seed, "optimizer", self.name)
            problem = design_problem(self.plan, self.fixed, weights_learn=self.training)
            self.optimizer = GuardedOptimizer(self.plan.optimizer, self.space, rng, problem)

    # what is simulated ------------------------------------------------------------------------------------

    @property
    def training(self) -> bool:
        """Whether tasks learn while it goes on."""
        trains = (self.plan.recipe.nodes[name].train for name in self.plan.trainable)
        return any(train is not None and train.weights != "frozen" for train in trains)

    @property
    def _weights(self) -> str:
        """How weights pass from candidate to candidate: shared, branched or frozen."""
        modes = {t.weights for n in self.plan.trainable if (t := self.plan.recipe.nodes[n].train) is not None}
        return next((mode for mode in ("shared", "branched") if mode in modes), "frozen")

    def _episodes(self, purpose: str, count: int) -> tuple[EpisodeSpec, ...]:
        return scored_episodes(self.plan.recipe, purpose, count, self.generation)

    def _training_episode(self, candidate: int) -> EpisodeSpec | None:
        """The episode a candidate, counted in its generation, trains on; None where no task is trained."""
        return training_episode(self.plan.recipe, self.generation, candidate) if self.training else None

    @property
    def _repeatable(self) -> bool:
        """Whether a candidate gets the same scores in another generation: same episodes, same weights."""
        return self.plan.recipe.study.renew_episodes == "never" and not self.training

    @property
    def comparable(self) -> bool:
        """Whether the fitness of all candidates compares: the same for all, and all episodes for each."""
        return self._repeatable and not self.partly_scored

    def expected_candidates(self) -> int | None:
        """How many candidates are still to come, elites counted each time, if that is known."""
        if self.optimizer is None:
            return max(0, (self.budget or 1) - self.n_observed) if self.training else 1
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
        asked = self.optimizer.ask() if self.optimizer else []
        if self.optimizer and not asked:
            self.stopped = self._stop()
            return []
        jobs = self._jobs(asked)
        failing, seen = replace(self.failing), list[Evaluation]()
        limit = limit_of(None if self.generation else len(jobs))

        def see(evaluation: Evaluation) -> None:
            on_evaluated(evaluation)
            seen.append(evaluation)
            failing.saw(evaluation, limit)

        try:
            found, states = self._evaluate(jobs, executor, evaluate, see)
        except KeepsFailing as error:
            error.evaluations = seen
            raise
        self.failing = failing
        numbers = [self._numbers(each) for each in asked] or [self._numbers(None)] * len(jobs)
        evaluations = [replace(e, episode_numbers=n) for e, n in zip(found, numbers, strict=True)]
        if self.optimizer:
            self.optimizer.tell([told_of(a, e) for a, e in zip(asked, evaluations, strict=True)])
        self.partly_scored |= any(len(n) < self._episode_count for n in numbers)
        self._remember(evaluations)
        self.states = states
        self.generation += 1
        self.stopped = self._stop()
        return evaluations

    def _stop(self) -> str | None:
        if self.optimizer is None:
            if self.training and self.evaluations < (self.budget or 1) and not self.broken_in_a_row:
                return None  # its tasks train on it as long as they may on the others
            return "nothing is left free to search"
        if self.broken_in_a_row >= MOST_BROKEN_IN_A_ROW:
            many = self.broken_in_a_row
            return f"{many} candidates in a row broke a constraint, the last as {self.last_failure}"
        if self.budget is not None and self.evaluations >= self.budget:
            return f"{self.evaluations} evaluations, the budget of {self.budget}, are spent"
        return self.optimizer.stop()

    @property
    def _episode_count(self) -> int:
        """How many episodes there are to score a candidate on, blocks counted each."""
        return self.plan.recipe.study.episodes * self.plan.recipe.study.blocks

    def _numbers(self, asked: Asked | None) -> tuple[int, ...]:
        """The episodes a candidate is scored on."""
        return (
            tuple(range(self._episode_count)) if asked is None or asked.episodes is None else asked.episodes
        )

    @property
    def _rounds(self) -> int:
        """How often the one candidate of a search that is free in nothing is trained on in this generation.

        Weights that candidates share learn from it as often as from the designs, in as many worlds.
        """
        generations = self.design.generation if self.design else 0
        if self._weights != "shared" or not self.budget or self.generation >= generations:
            return 1
        before, until = (self.budget * (self.generation + i) // generations for i in (0, 1))
        return max(1, min(until - before, self.budget - self.evaluations))

    def _jobs(self, asked: Sequence[Asked]) -> list[ScoreJob]:
        """What scoring each candidate is; the one there is, where nothing is free."""
        episodes = self._episodes("design", self.plan.recipe.study.episodes)
        if self.optimizer is None:
            trainings = [self._training_episode(i) for i in range(self._rounds)]
            return [ScoreJob(dict(self.fixed), episodes, self.states, each) for each in trainings]
        jobs = []
        for i, each in enumerate(asked):
            numbers = self._numbers(each)
            if self.plan.recipe.study.race is not None and len(numbers) < len(episodes):
                raise UserError(_race_of_parts(self.plan, self.optimizer.origin, numbers))
            values = {**self.fixed, **each.candidate.as_dict()}
            specs = tuple(episodes[number] for number in numbers)
            jobs.append(ScoreJob(values, specs, self.states, self._training_episode(i)))
        return jobs

    def _evaluate(
        self,
        jobs: Sequence[ScoreJob],
        executor: Executor,
        evaluate: Evaluator,
        on_evaluated: Callable[[Evaluation], None],
    ) -> tuple[list[Evaluation], dict[str, State]]:
        if self.training and self._weights == "shared":
            evaluations, states = [], dict(self.states)
            for evaluation in score_pipelined(jobs, self.plan.fitness, executor, evaluate):
                states.update(evaluation.states)
                evaluations.append(evaluation)
                on_evaluated(evaluation)
            return evaluations, states
        evaluations = self._cached_map(jobs, executor, evaluate, on_evaluated)
        states = dict(self.states)
        if self.training and (scored := [e for e in evaluations if e.fitness is not None]):
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
        if self._repeatable:  # otherwise no later generation can ask the same again
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
            self.evaluations += not (evaluation.cached or evaluation.broken)
            self.images += evaluation.images
            self.broken_in_a_row = self.broken_in_a_row + 1 if evaluation.broken else 0
            if evaluation.fitness is None:
                self.last_failure = evaluation.failed
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
        """Score the best few once more, on episodes that none was chosen by; `best` is then the best of them.

        The best of many noisy scores is too good to be true (the winner's curse), and scores of different
        episodes, or of weights that have learnt meanwhile, do not even compare. Nothing is scored where
        there is nothing to choose between.

        Returns
        -------
        The evaluations of the finalists, the most promising first.
        """
        self.finalists_rescored = True
        wanted = self.most_promising(self.plan.recipe.study.finalists)
        settled = self.comparable and len(wanted) < 2
        if not wanted or settled or len(self.candidate_stats) < 2:
            return []
        study = self.plan.recipe.study
        episodes = self._episodes("final", study.final_episodes or study.episodes)
        jobs = [ScoreJob(values, episodes, self.states) for values in wanted]
        finalists = []
        for found in score_sharded(jobs, self.plan.fitness, executor, evaluate):
            finalists.append(replace(found, episode_numbers=tuple(range(len(episodes)))))
            on_evaluated(finalists[-1])
        self.evaluations += sum(not evaluation.broken for evaluation in finalists)
        self.images += sum(evaluation.images for evaluation in finalists)
        self.finalists = finalists
        if scored := [e for e in finalists if e.fitness is not None]:
            self.best = max(scored, key=_fitness)
        return finalists

    def most_promising(self, count: int) -> list[Mapping[str, Any]]:
        """Values of the candidates the optimizer recommends, else of those with the best mean fitness."""
        if self.optimizer and (recommended := self.optimizer.recommend(count)):
            return [{**self.fixed, **candidate.as_dict()} for candidate in recommended]
        ranked = sorted(self.candidate_stats.values(), key=lambda stats: -stats.mean_fitness)
        return [stats.values for stats in ranked[:count]]

    # the network of the camera that was chosen ------------------------------------------------------------

    @property
    def rounds(self) -> int:
        """How often the states may have changed: generations, and trainings on the best."""
        return self.generation + self.trained_best

    def next_training_on_best(self) -> ScoreJob | None:
        """The next training on the best camera, if one is left."""
        if self.best is None or not self.training or self.trained_best >= self.plan.recipe.study.train_best:
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
            **{name: getattr(self, name) for name in _PLAIN_STATE},
            "finalists": [as_data(evaluation) for evaluation in self.finalists],
            "best": self.best and as_data(self.best),
            "failing": asdict(self.failing),
            "candidate_stats": {key: asdict(stats) for key, stats in self.candidate_stats.items()},
            "cache": {key: as_data(evaluation) for key, evaluation in self.cache.items()},
            "optimizer": self.optimizer and self.optimizer.state(),
        }

    def restore(self, state: Mapping[str, Any], states: dict[str, State]) -> None:
        """Go on from a `state`."""
        for name in _PLAIN_STATE:
            setattr(self, name, state[name])
        self.finalists = [Evaluation(**evaluation) for evaluation in state["finalists"]]
        self.best = Evaluation(**state["best"]) if state["best"] else None
        self.candidate_stats = {
            key: CandidateStats(**stats) for key, stats in state["candidate_stats"].items()
        }
        self.cache = {key: Evaluation(**evaluation) for key, evaluation in state["cache"].items()}
        self.failing = FailuresInARow(**state["failing"])
        self.states = states
        if self.optimizer:
            self.optimizer.restore(state["optimizer"])


def _race_of_parts(plan: Plan, optimizer: str, numbers: Sequence[int]) -> Fault:
    return Fault(
        plan.recipe.where(("study", "race")),
        f"candidates cannot race: {optimizer} asks for one to be scored on episodes "
        f"{', '.join(map(str, numbers))} only",
        "an optimizer that has all candidates scored on all episodes",
        "Take study.race out, or set the optimizer to score candidates on all episodes.",
    )


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
