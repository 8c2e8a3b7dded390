"""Cameras scored in shards, one for each world: a worker that has built a world goes on in it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import groupby, islice

from tacos_framework.contracts import Executor
from tacos_framework.simulation import Evaluation, Evaluator, ScoreJob, merged_evaluation


def score_sharded(jobs: Sequence[ScoreJob], executor: Executor, evaluate: Evaluator) -> Iterator[Evaluation]:
    """Score cameras world by world.

    What costs most on the first image of a world is to build and light it. An executor that minds what jobs
    have an affinity to thus builds each world in one process, and no worker idles where there are more worlds
    than workers.

    `jobs`: scoring each camera. Those that train are left whole, as they score with what they learn.

    Yields: the evaluation of each job, in their order; the same for any number of workers.
    """
    shards = [by_world(job) for job in jobs]
    results = iter(executor.map(evaluate, [shard for of_job in shards for shard in of_job]))
    for of_job in shards:
        evaluations = list(islice(results, len(of_job)))
        yield evaluations[0] if len(of_job) == 1 else merged_evaluation(evaluations, evaluate.plan.fitness)
    for _ in results:  # to the end: there an executor cleans up, and one that gives too many is found out
        pass


def by_world(job: ScoreJob) -> list[ScoreJob]:
    """The job in runs of episodes in the same world; one that trains is left whole."""
    runs = [tuple(run) for _, run in groupby(job.episodes, key=lambda spec: spec.world)]
    if job.training is not None or len(runs) < 2:
        return [job]
    return [replace(job, episodes=run, partial=True) for run in runs]
