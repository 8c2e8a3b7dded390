"""Cameras scored in shards: one for each world, with the result of the whole."""

from __future__ import annotations

from dataclasses import replace

import pytest
from toy_study import toy_recipe

from tacos_framework.errors import ContractBroken
from tacos_framework.plugins.executing import GuardedExecutor
from tacos_framework.simulation import EpisodeSpec, Evaluator, PrepareJob, ScoreJob
from tacos_framework.study.shards import score_sharded
from tacos_framework.testing.fingerprint import fingerprint

EPISODES = tuple(EpisodeSpec(9, ("test", i), frames=2) for i in range(5))


class Counting:
    """An executor that notes the jobs."""

    def __init__(self) -> None:
        self.jobs: list[ScoreJob] = []

    def map(self, evaluate, jobs):
        self.jobs = list(jobs)
        return map(evaluate, jobs)


def camera(focal_length_mm: float, blocks: int = 1) -> ScoreJob:
    episodes = tuple(replace(spec, block=(i, blocks)) for spec in EPISODES for i in range(blocks))
    return ScoreJob({"focal_length_mm": focal_length_mm, "pitch_deg": 0.0}, episodes)


@pytest.mark.parametrize(
    ("cameras", "blocks", "episodes"),
    [(1, 1, [1] * 5), (3, 1, [1] * 15), (1, 2, [2] * 5), (0, 1, [])],
)
def test_every_world_is_a_job_of_its_own_and_nothing_changes(toys, cameras, blocks, episodes):
    evaluate, executor = Evaluator(toy_recipe(), toys), Counting()
    jobs = [camera(focal_length_mm, blocks) for focal_length_mm in (1.0, 0.6, 3.0)[:cameras]]
    in_parts = list(score_sharded(jobs, executor, evaluate))
    assert [len(job.episodes) for job in executor.jobs] == episodes
    assert len({job.affinity for job in executor.jobs}) == (5 if cameras else 0)
    whole = [evaluate(job) for job in jobs]
    assert [fingerprint(replace(e, seconds={})) for e in in_parts] == [
        fingerprint(replace(e, seconds={})) for e in whole
    ]


def test_a_part_that_fails_fails_the_camera(toys):
    evaluate = Evaluator(toy_recipe(nodes={"width": {"fail_above_deg": 60}}), toys)
    (wide,) = score_sharded([camera(0.6)], Counting(), evaluate)
    assert wide.failed
    assert wide.failed.startswith("cannot judge")
    assert wide.fitness is None


def test_a_camera_that_trains_is_left_whole(toys):
    evaluate, executor = Evaluator(toy_recipe(), toys), Counting()
    training = EpisodeSpec(9, ("train", 0, 0))
    job = replace(camera(1.0), training=training)
    list(score_sharded([job], executor, evaluate))
    assert executor.jobs == [job]
    assert job.affinity == PrepareJob(job.values, training).affinity != replace(job, values={}).affinity


class Generous(Counting):
    """Gives one result too many, and says when it was read to its end."""

    read = False

    def map(self, evaluate, jobs):
        results = list(super().map(evaluate, jobs))
        yield from results
        self.read = True
        yield results[-1]


def test_results_are_read_to_their_end(toys):
    """There an executor cleans up, and one that gives too many is found out."""
    evaluate, executor = Evaluator(toy_recipe(), toys), Generous()
    assert len(list(score_sharded([camera(1.0)], executor, evaluate))) == 1
    assert executor.read
    with pytest.raises(ContractBroken, match="twice"):
        list(score_sharded([camera(1.0)], GuardedExecutor.of_host(Generous()), evaluate))
