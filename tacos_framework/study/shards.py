"""A few cameras on many episodes: cut into shards, so that no worker idles."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import islice, pairwise

from tacos_framework.contracts import Executor
from tacos_framework.fitness import Fitness
from tacos_framework.simulation import Evaluation, Evaluator, ScoreJob, merged_evaluation


def score_sharded(
    jobs: Sequence[ScoreJob], fitness: Fitness, executor: Executor, evaluate: Evaluator
) -> Iterator[Evaluation]:
    """Score cameras, each in as many shards as it takes to give every worker something to do.

    Parameters
    ----------
    jobs
        Scoring each camera, without training.
    fitness
        The weighted sum of scores.
    executor, evaluate
        Run the jobs; an executor without ``workers`` has one.

    Yields
    ------
    The evaluation of each job, in their order; the same for any number of workers.
    """
    workers = getattr(executor, "workers", 1)
    shards = [_shards(job, math.ceil(workers / len(jobs))) for job in jobs]
    results = iter(executor.map(evaluate, [shard for of_job in shards for shard in of_job]))
    for of_job in shards:
        yield merged_evaluation(list(islice(results, len(of_job))), fitness)


def _shards(job: ScoreJob, count: int) -> list[ScoreJob]:
    """The job in at most `count` nearly equal runs of episodes."""
    count = min(count, len(job.episodes))
    ends = [len(job.episodes) * i // count for i in range(count + 1)]
    return [replace(job, episodes=job.episodes[start:stop], partial=True) for start, stop in pairwise(ends)]
