"""Weights that candidates share: the training of the next one is pipelined with the scoring of the last."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import zip_longest

from tacos_framework.contracts import Executor
from tacos_framework.fitness import Fitness
from tacos_framework.simulation import Evaluation, Evaluator, PrepareJob, ScoreJob, merged_evaluation
from tacos_framework.simulation.jobs import Job
from tacos_framework.study.shards import by_world


@dataclass(frozen=True)
class _Trained:
    """A candidate that has trained, and what scoring it will be, world by world."""

    training: Evaluation
    scoring: Sequence[ScoreJob]

    def scored(self, beside: Sequence[Evaluation], fitness: Fitness) -> Evaluation:
        """The whole evaluation with what was done beside the next; what was learnt stays if scoring fails."""
        return replace(merged_evaluation([self.training, *beside], fitness), states=self.training.states)


def score_pipelined(
    jobs: Sequence[ScoreJob], fitness: Fitness, executor: Executor, evaluate: Evaluator
) -> Iterator[Evaluation]:
    """Train and score candidates whose weights pass from one to the next.

    Scoring needs a candidate's weights, and so does the training of the next one, but neither needs the
    other; and what a candidate trains on can be rendered before the weights are there. Where an executor
    has several workers, one trains while the others score the last candidate, world by world, and render for
    the next; then it helps with the scoring. A single worker does one after the other, with the same results.

    Parameters
    ----------
    jobs
        Training on and scoring each candidate, in their order; where the first begins stands in its states.
    fitness
        The weighted sum of scores.
    executor, evaluate
        Run the jobs.

    Yields
    ------
    The evaluation of each job. One that fails in training has no states: the next goes on from those before.
    """
    states = dict(jobs[0].states)
    last: _Trained | None = None
    done: list[Evaluation] = []
    for job, following in zip_longest(jobs, jobs[1:]):
        training = replace(job, states=states, episodes=(), partial=True)
        scoring = last.scoring if last else ()
        together: list[Job[Evaluation]] = [training, *_prepared(job, following, executor), *scoring]
        trained, *others = executor.map(evaluate, together)
        done += others
        if last:
            yield last.scored(done, fitness)
            done = []
        last = None
        if trained.failed:
            yield trained
        else:
            states = {**states, **trained.states}
            last = _Trained(trained, by_world(replace(job, states=states, training=None, partial=True)))
    if last:
        yield last.scored([*done, *executor.map(evaluate, last.scoring)], fitness)


def _prepared(job: ScoreJob, following: ScoreJob | None, executor: Executor) -> Iterator[PrepareJob]:
    """Rendering what the next candidate trains on, where a worker is free while this one trains."""
    if getattr(executor, "workers", 1) > 1 and job.training and following and following.training:
        yield PrepareJob(following.values, following.training)
