"""Weights that candidates share: the training of the next one is pipelined with the scoring of the last."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice, zip_longest

from tacos_framework.contracts import Executor, ExecutorBase, optional
from tacos_framework.fitness import Fitness
from tacos_framework.simulation import Evaluation, Evaluator, PrepareJob, ScoreJob, merged_evaluation
from tacos_framework.simulation.jobs import Job
from tacos_framework.study.shards import by_world


@dataclass(frozen=True)
class _Trained:
    """A candidate that has trained, and what scoring it will be, world by world; nothing where it failed."""

    training: Evaluation
    scoring: Sequence[ScoreJob]

    def scored(self, beside: Sequence[Evaluation], fitness: Fitness) -> Evaluation:
        """The whole evaluation with what was done beside the next; what was learnt stays if scoring fails."""
        return replace(merged_evaluation([self.training, *beside], fitness), states=self.training.states)


def score_pipelined(
    jobs: Sequence[ScoreJob], executor: Executor, evaluate: Evaluator
) -> Iterator[Evaluation]:
    """Train and score candidates whose weights pass from one to the next.

    Scoring needs a candidate's weights, and so does the training of the next one, but neither needs the
    other; and what a candidate trains on can be rendered before the weights are there. Where an executor
    has several workers, one trains while another renders for the next. Candidates are scored, world by
    world, when as many wait for it as there are workers, or nothing is left to render: in rounds of a
    training, a rendering and one scoring of about equal length, every fourth of two workers' time would pass
    idle. A single worker does one after the other, with the same results.

    `jobs`: training on and scoring each candidate, in their order; where the first begins stands in its
    states.

    Yields: the evaluation of each job. One that fails in training has no states: the next goes on from those
    before.
    """
    states, fitness = dict(jobs[0].states), evaluate.plan.fitness
    waiting: list[_Trained] = []
    beside: list[Evaluation] = []
    for job, following in zip_longest(jobs, jobs[1:]):
        training = replace(job, states=states, episodes=(), partial=True)
        ahead = list(_prepared(job, following, executor))
        due = waiting if len(waiting) >= _workers(executor) or not ahead else []
        together: list[Job[Evaluation]] = [training, *ahead, *_scoring(due)]
        trained, *others = executor.map(evaluate, together)
        beside += others[: len(ahead)]
        yield from _scored(due, others[len(ahead) :], beside, fitness)
        if due:
            waiting, beside = [], []
        scoring: Sequence[ScoreJob] = ()
        if not trained.failed:
            states = {**states, **trained.states}
            scoring = by_world(replace(job, states=states, training=None, partial=True))
        waiting.append(_Trained(trained, scoring))
    last = _scoring(waiting)
    yield from _scored(waiting, list(executor.map(evaluate, last)) if last else [], beside, fitness)


def _scoring(candidates: Sequence[_Trained]) -> list[ScoreJob]:
    return [job for each in candidates for job in each.scoring]


def _scored(
    candidates: Sequence[_Trained],
    scores: Sequence[Evaluation],
    beside: Sequence[Evaluation],
    fitness: Fitness,
) -> Iterator[Evaluation]:
    """The evaluations of candidates; the time of what was done beside them counts for the first."""
    of_all = iter(scores)
    for each in candidates:
        yield each.scored([*beside, *islice(of_all, len(each.scoring))], fitness)
        beside = ()


def _workers(executor: Executor) -> int:
    return int(optional(executor, ExecutorBase, "workers"))


def _prepared(job: ScoreJob, following: ScoreJob | None, executor: Executor) -> Iterator[PrepareJob]:
    """Rendering what the next candidate trains on, where a worker is free while this one trains."""
    if _workers(executor) > 1 and job.training and following and following.training:
        yield PrepareJob(following.values, following.training)
