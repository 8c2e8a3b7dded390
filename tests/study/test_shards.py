"""Cameras scored in shards: as many as there are workers, with the result of the whole."""

from __future__ import annotations

from dataclasses import replace

import pytest
from toy_study import toy_recipe

from tacos_framework.simulation import EpisodeSpec, Evaluator, ScoreJob
from tacos_framework.study.shards import score_sharded
from tacos_framework.testing.fingerprint import fingerprint

EPISODES = tuple(EpisodeSpec(9, ("test", i), frames=2) for i in range(5))


class Counting:
    """An executor that notes how many episodes each job has."""

    def __init__(self, workers: int):
        self.workers = workers
        self.episodes: list[int] = []

    def map(self, evaluate, jobs):
        self.episodes = [len(job.episodes) for job in jobs]
        return map(evaluate, jobs)


def camera(focal_length_mm: float) -> ScoreJob:
    return ScoreJob({"focal_length_mm": focal_length_mm, "pitch_deg": 0.0}, EPISODES)


@pytest.mark.parametrize(
    ("cameras", "workers", "episodes"),
    [
        (1, 1, [5]),
        (1, 2, [2, 3]),
        (1, 8, [1, 1, 1, 1, 1]),
        (3, 2, [5, 5, 5]),
        (2, 4, [2, 3, 2, 3]),
        (0, 2, []),
    ],
)
def test_parts_keep_every_worker_busy_and_change_nothing(toys, cameras, workers, episodes):
    evaluate, executor = Evaluator(toy_recipe(), toys), Counting(workers)
    jobs = [camera(focal_length_mm) for focal_length_mm in (1.0, 0.6, 3.0)[:cameras]]
    fitness = evaluate.simulation.plan.fitness
    in_parts = list(score_sharded(jobs, fitness, executor, evaluate))
    assert executor.episodes == episodes
    whole = [evaluate(job) for job in jobs]
    assert [fingerprint(replace(e, seconds={})) for e in in_parts] == [
        fingerprint(replace(e, seconds={})) for e in whole
    ]


def test_a_part_that_fails_fails_the_camera(toys):
    evaluate = Evaluator(toy_recipe(nodes={"width": {"fail_above_deg": 60}}), toys)
    fitness = evaluate.simulation.plan.fitness
    (wide,) = score_sharded([camera(0.6)], fitness, Counting(2), evaluate)
    assert wide.failed
    assert wide.failed.startswith("cannot judge")
    assert wide.fitness is None
