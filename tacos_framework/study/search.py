"""One run of an optimizer over a design space: ask, simulate, train, score, tell."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from tacos_framework.contracts import Asked, Executor, State
from tacos_framework.randomness import generator
from tacos_framework.simulation import EpisodeSpec, Evaluation, Evaluator, ScoreJob
from tacos_framework.study.episodes import scored_episodes, training_episode
from tacos_framework.study.failure_policy import MOST_ALIKE, KeepsFailing, limit_of
from tacos_framework.study.guarded_optimizer import GuardedOptimizer, not_evaluated, result_of
from tacos_framework.study.pipelined import score_pipelined
from tacos_framework.study.problem import broken_by, design_problem
from tacos_framework.study.search_state import EndOfSearch, SearchState, fitness_of
from tacos_framework.study.unique_evaluations import evaluate_each_once, job_keys

MOST_BROKEN_IN_A_ROW = 1000
"""After so many candidates in a row that break a constraint, no more are asked for."""


@dataclass
class Search(SearchState):
    """One search; `step` takes it one generation further. See `SearchState` for its parameters."""

    design: Search | None = None
    """The search whose worlds its tasks train in; None for that search itself."""

    def __post_init__(self) -> None:
        self.optimizer: GuardedOptimizer | None = None
        if self.space is not None:
            rng = generator(self.plan.recipe.seed, "optimizer", self.name)
            problem = design_problem(self.plan, self.fixed, weights_learn=self.training)
            self.optimizer = GuardedOptimizer(self.plan.optimizer, self.space, rng, problem)

    # what is simulated ------------------------------------------------------------------------------------

    def _episodes(self, purpose: str, count: int) -> tuple[EpisodeSpec, ...]:
        return scored_episodes(self.plan.recipe, purpose, count, self.generation)

    def _training_episode(self, candidate: int) -> EpisodeSpec | None:
        """The episode a candidate, counted in its generation, trains on; None where no task is trained."""
        return training_episode(self.plan.recipe, self.generation, candidate) if self.training else None

    def expected_candidates(self) -> int | None:
        """Number of candidates still to come, elites counted each time, if that is known."""
        if self.optimizer is None:
            return max(0, (self.budget or 1) - self.n_observed) if self.training else 1
        known = [n for n in (self.optimizer.expected_candidates, self.budget) if n is not None]
        return max(0, min(known) - self.n_observed) if known else None

    # one generation ---------------------------------------------------------------------------------------

    def step(
        self, executor: Executor, evaluate: Evaluator, on_evaluated: Callable[[Evaluation], None]
    ) -> list[Evaluation]:
        """Ask for candidates, evaluate them, tell; returns the evaluations, in the order asked.

        The search is changed only once all are there, so that a break in the middle loses this generation
        and nothing else.

        Raises `KeepsFailing` when candidates fail one after the other by the same defect of a component.
        """
        asked = self.optimizer.ask() if self.optimizer else []
        if self.optimizer and not asked:
            self.stopped = self._stop()
            return []
        jobs = self._jobs(asked)
        jobs = jobs[: self._affordable(jobs)]
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
        done, left_out = asked[: len(jobs)], asked[len(jobs) :]
        numbers = [self._numbers(each) for each in done] or [self._numbers(None)] * len(jobs)
        evaluations = [replace(e, episode_numbers=n) for e, n in zip(found, numbers, strict=True)]
        if self.optimizer:
            results = [result_of(a, e) for a, e in zip(done, evaluations, strict=True)]
            self.optimizer.tell([*results, *(not_evaluated(each, self._spent) for each in left_out)])
        self.partly_scored |= any(len(n) < self._episode_count for n in numbers)
        self.remember(evaluations)
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
        if not self.candidate_stats and self.failed_alike >= MOST_ALIKE:
            return (
                f"none of {self.failed_alike} candidates could be scored, and all failed for one reason, "
                f"the last: {self.last_failure}"
            )
        if self.budget is not None and self.evaluations >= self.budget:
            return self._spent
        return self.optimizer.stop()

    @property
    def _spent(self) -> str:
        return f"{self.budget} evaluations, the budget of {self.budget}, are spent"

    def _affordable(self, jobs: Sequence[ScoreJob]) -> int:
        """Number of candidates, from the first, that the budget allows: those without cost do not count."""
        if self.budget is None or self.optimizer is None:
            return len(jobs)
        left, counted = self.budget - self.evaluations, set(self.cache)
        for number, (key, job) in enumerate(zip(job_keys(jobs), jobs, strict=True)):
            if key in counted or broken_by(self.plan, job.values):
                continue
            if left == 0:
                return number
            left -= 1
            counted.add(key)
        return len(jobs)

    @property
    def _episode_count(self) -> int:
        """Number of episodes to score a candidate on, blocks counted each."""
        return self.plan.recipe.study.episodes * self.plan.recipe.study.blocks

    def _numbers(self, asked: Asked | None) -> tuple[int, ...]:
        """The episodes a candidate is scored on."""
        return (
            tuple(range(self._episode_count)) if asked is None or asked.episodes is None else asked.episodes
        )

    @property
    def _rounds(self) -> int:
        """Number of trainings on the one candidate of a search without free variables in this generation.

        Weights that candidates share learn from it as often as from the designs, in as many worlds.
        """
        generations = self.design.generation if self.design else 0
        if self.weights_mode != "shared" or not self.budget or self.generation >= generations:
            return 1
        before, until = (self.budget * (self.generation + i) // generations for i in (0, 1))
        return max(1, min(until - before, self.budget - self.evaluations))

    def _jobs(self, asked: Sequence[Asked]) -> list[ScoreJob]:
        """The job that scores a candidate; the only one where nothing is free."""
        episodes = self._episodes("design", self.plan.recipe.study.episodes)
        if self.optimizer is None:
            trainings = [self._training_episode(i) for i in range(self._rounds)]
            return [ScoreJob(dict(self.fixed), episodes, self.states, each) for each in trainings]
        jobs = []
        for i, each in enumerate(asked):
            numbers = self._numbers(each)
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
        states = dict(self.states)
        if self.training and self.weights_mode == "shared":
            evaluations = []
            for evaluation in score_pipelined(jobs, executor, evaluate):
                states.update(evaluation.states)
                evaluations.append(evaluation)
                on_evaluated(evaluation)
            return evaluations, states
        evaluations, fresh = evaluate_each_once(jobs, self.cache, executor, evaluate, on_evaluated)
        if self.repeatable:  # otherwise no later generation can ask the same again
            known = {key: e for key, e in fresh.items() if e.raised is None}  # a defect may be mended
            self.cache.update({key: replace(e, states={}) for key, e in known.items()})
        if self.training and (scored := [e for e in evaluations if e.fitness is not None]):
            states.update(max(scored, key=fitness_of).states)
        return evaluations, states

    @property
    def _final_episode_count(self) -> int:
        study = self.plan.recipe.study
        return study.final_episodes or study.episodes

    def finalist_values(self) -> list[Mapping[str, Any]]:
        """The cameras to choose the best among, the most promising first; none where that is settled.

        The best of many noisy scores is too good to be true (the winner's curse), and scores of different
        episodes, or of weights that have learnt meanwhile, do not even compare. So the best few are scored
        once more, on episodes that none was chosen by. An optimizer that models noise may choose by all it
        has seen.
        """
        wanted = self.most_promising(self.plan.recipe.study.finalists)
        settled = self.comparable and len(wanted) < 2
        return [] if settled or len(self.candidate_stats) < 2 else wanted

    def finalist_jobs(self, wanted: Sequence[Mapping[str, Any]]) -> list[ScoreJob]:
        """Scoring finalists on episodes of their own."""
        episodes = self._episodes("final", self._final_episode_count)
        return [ScoreJob(values, episodes, self.states) for values in wanted]

    def choose_among(self, finalists: Sequence[Evaluation]) -> None:
        """End the search with what came out for its `finalist_jobs`: `best` is then the best of them."""
        self._end()
        self.evaluations += sum(not evaluation.broken for evaluation in finalists)
        self.images += sum(evaluation.images for evaluation in finalists)
        numbers = tuple(range(self._final_episode_count))
        self.finalists = [replace(evaluation, episode_numbers=numbers) for evaluation in finalists]
        if scored := [e for e in self.finalists if e.fitness is not None]:
            self.best = self._best_of(scored)

    def choose_unscored(self, camera: Evaluation) -> None:
        """End the search with a camera that is yet to be scored, and has no fitness."""
        self._end()
        self.best = camera

    def _end(self) -> None:
        self.finalists_rescored = True
        self.searched = EndOfSearch(self.best, self.evaluations, self.images)

    def _best_of(self, finalists: Sequence[Evaluation]) -> Evaluation:
        """The one the optimizer chooses, else that of highest fitness."""
        if self.optimizer is None or self.space is None:
            return max(finalists, key=fitness_of)
        free = [{name: e.values[name] for name in self.space.names} for e in finalists]
        asked = [Asked(self.space.decode(self.space.encode(values))) for values in free]
        place = self.optimizer.choose([result_of(a, e) for a, e in zip(asked, finalists, strict=True)])
        return max(finalists, key=fitness_of) if place is None else finalists[place]

    def most_promising(self, count: int) -> list[Mapping[str, Any]]:
        """Values of the candidates the optimizer recommends, else of those with the best mean fitness."""
        if self.optimizer and (recommended := self.optimizer.recommend(count)):
            return [{**self.fixed, **candidate.as_dict()} for candidate in recommended]
        ranked = sorted(self.candidate_stats.values(), key=lambda stats: -stats.mean_fitness)
        return [stats.values for stats in ranked[:count]]

    # the network of the camera that was chosen ------------------------------------------------------------

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
        return {**self.as_data(), "optimizer": self.optimizer and self.optimizer.state()}

    def restore(self, state: Mapping[str, Any], states: dict[str, State]) -> None:
        self.take_up(state, states)
        if self.optimizer:
            self.optimizer.restore(state["optimizer"])

    def reopen(self) -> bool:
        """Go on searching where the optimizer, given more to spend, has more to ask; whether it has.

        The search is then as it was before its finalists were scored; the states of tasks are not.
        """
        if self.optimizer is None or self.stopped is None or self._stop() is not None:
            return False
        self.stopped = None
        if self.searched is not None:
            self.best, self.images = self.searched.best, self.searched.images
            self.evaluations = self.searched.evaluations
        self.finalists, self.finalists_rescored, self.searched, self.trained_best = [], False, None, 0
        return True
