"""Worlds that the test needs are built by workers that would wait, and nobody waits for them."""

from __future__ import annotations

import time
from functools import partial
from pathlib import Path

import pytest
from toy_study import comparable, run, toy_recipe

from tacos_framework.simulation import BuildJob, EpisodeSpec, ScoreJob
from tacos_framework.study.worlds_ahead import OFFERED, BuildingAhead
from tacos_plugins.executors.process import ProcessExecutor

WORLDS = [EpisodeSpec(1, ("test", i)) for i in range(3)]


class Recording:
    """An executor that writes down what it begins."""

    def __init__(self, workers):
        self.workers, self.begun = workers, []

    def map(self, evaluate, jobs):
        for job in jobs:
            self.begun.append(job)
            yield evaluate(job)

    def close(self):
        pass


def jobs(*seconds):
    return [ScoreJob({"seconds": each}, ()) for each in seconds]


def waits_or_builds(folder: Path, job):
    """Leaves a file for a world, else sleeps and gives how long."""
    if isinstance(job, BuildJob):
        (folder / str(job.episode.name[-1])).touch()
        return None
    time.sleep(job.values["seconds"])
    return job.values["seconds"]


def test_a_worker_that_would_wait_builds_a_world(tmp_path):
    executor = ProcessExecutor(ProcessExecutor.Config(workers=2))
    evaluate = partial(waits_or_builds, tmp_path)
    ahead = BuildingAhead(executor, WORLDS)
    try:
        list(executor.map(evaluate, jobs(0.3, 0.3)))  # both workers are there
        assert list(ahead.map(evaluate, jobs(0.0, 1.0))) == [0.0, 1.0]
        assert [path.name for path in tmp_path.iterdir()] == ["0"]
    finally:
        executor.close()


def test_nobody_waits_for_a_world_and_it_is_offered_again():
    executor = Recording(workers=2)
    ahead = BuildingAhead(executor, WORLDS)
    for _ in range(4):
        assert list(ahead.map(lambda job: job.values["seconds"], jobs(1, 2))) == [1, 2]
    assert not any(isinstance(job, BuildJob) for job in executor.begun)  # it does them in order, when asked
    offered = [next(ahead._ahead(jobs(1, 2))).episode for _ in range(2)]
    assert offered == [WORLDS[1], WORLDS[2]]  # of three, after four


def test_a_world_is_not_offered_for_ever():
    ahead = BuildingAhead(Recording(workers=2), WORLDS)
    offered = [job.episode for _ in range(100) for job in ahead._ahead(jobs(1, 2))]
    assert offered == WORLDS * OFFERED


@pytest.mark.parametrize(("workers", "given", "offered"), [(2, 2, 1), (2, 5, 1), (8, 2, 6), (2, 0, 0)])
def test_worlds_are_offered_to_all_workers_without_a_job(workers, given, offered):
    ahead = BuildingAhead(Recording(workers), WORLDS * 3)
    assert len(list(ahead._ahead(jobs(*range(given))))) == offered


@pytest.mark.parametrize(("workers", "worlds"), [(1, WORLDS), (2, [])])
def test_all_is_as_before_where_nothing_can_be_built_ahead(workers, worlds):
    executor = Recording(workers)
    assert list(BuildingAhead(executor, worlds).map(lambda job: job, jobs(1, 2))) == jobs(1, 2)
    assert executor.begun == jobs(1, 2)


def test_a_world_that_cannot_be_built_is_told_where_it_is_needed(caplog):
    class Broken:
        def sample(self, values, spec, position):
            raise OSError("no room")

    caplog.set_level("INFO", "tacos_framework")
    assert BuildJob({}, WORLDS[0]).run(Broken()) is None
    assert "a world was not built ahead: OSError: no room" in caplog.text


def test_a_study_comes_to_the_same(toys, tmp_path, monkeypatch):
    recipe = toy_recipe(executor={"use": "executor.process", "workers": 2})
    with_worlds_ahead = run(recipe, toys, tmp_path / "ahead")
    monkeypatch.setattr(BuildingAhead, "_ahead", lambda self, jobs: iter(()))
    assert comparable(run(recipe, toys, tmp_path / "not")) == comparable(with_worlds_ahead)
