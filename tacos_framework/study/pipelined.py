"""Weights that candidates share: the training of the next one is pipelined with the scoring of the last."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from tacos_framework.contracts import Executor
from tacos_framework.fitness import Fitness
from tacos_framework.simulation import Evaluation, Evaluator, ScoreJob, merged_evaluation


@dataclass(frozen=True)
class _Trained:
    """A candidate that has trained, and what scoring it will be."""

    training: Evaluation
    scoring: ScoreJob

    def scored(self, scores: Evaluation, fitness: Fitness) -> Evaluation:
        """The whole evaluation; what was learnt stays even where scoring fails."""
        return replace(merged_evaluation([self.training, scores], fitness), states=self.training.states)


def score_pipelined(
    jobs: Sequence[ScoreJob], fitness: Fitness, executor: Executor, evaluate: Evaluator
) -> Iterator[Evaluation]:
    """Train and score candidates whose weights pass from one to the next.

    Scoring needs a candidate's weights, and so does the training of the next one, but neither needs the
    other: an executor of two workers does both at a time, one of a single worker one after the other, with
    the same results.

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
    for job in jobs:
        training = replace(job, states=states, episodes=(), partial=True)
        trained, *scores = executor.map(evaluate, [training, last.scoring] if last else [training])
        if last:
            yield last.scored(scores[0], fitness)
        last = None
        if trained.failed:
            yield trained
        else:
            states = {**states, **trained.states}
            last = _Trained(trained, replace(job, states=states, training=None, partial=True))
    if last:
        (final,) = executor.map(evaluate, [last.scoring])
        yield last.scored(final, fitness)
