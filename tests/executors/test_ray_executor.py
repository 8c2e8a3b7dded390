"""Evaluation on Ray: a cluster of our own on this machine, with workers that are lost."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import time
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import pytest
import toy_plugin
from toy_study import LEARNER, comparable, run, toy_recipe

from tacos_framework.errors import UserError
from tacos_framework.hookspecs import hookimpl
from tacos_framework.plugins import Plugins
from tacos_plugins.executors.on_ray.cluster import Needs
from tacos_plugins.executors.on_ray.executor import RayExecutor
from tacos_plugins.executors.outcomes import JobLost, WorkerTraceback
from tests.executors import jobs

# looked for, not imported: the executor chooses how Ray is set up before it is
pytestmark = pytest.mark.skipif(find_spec("ray") is None, reason="the extra ray is not installed")


@pytest.fixture(scope="module")
def two_workers() -> Iterator[RayExecutor]:
    executor = RayExecutor(RayExecutor.Config(workers=2, attempts=2, cpus_per_worker=0.5))
    yield executor
    executor.close()


def test_results_come_in_the_order_of_the_jobs_from_other_processes(two_workers):
    assert list(two_workers.map(jobs.slow_square, range(6))) == [0, 1, 4, 9, 16, 25]
    pids = set(two_workers.map(jobs.process_id, range(6)))
    assert os.getpid() not in pids


def test_a_worker_that_is_killed_is_replaced_and_its_job_tried_again(two_workers, tmp_path):
    assert list(two_workers.map(jobs.DieOnFirstAttempt(tmp_path, at=2), range(5))) == [0, 1, 4, 9, 16]
    assert len(list(tmp_path.iterdir())) == 1


def test_a_job_whose_workers_all_die_is_answered_for_and_the_others_go_on(two_workers):
    results = list(two_workers.map(jobs.DieAt(1, "killed"), range(4)))
    assert results[:1] + results[2:] == [0, 4, 9]
    assert results[1] == "1 lost: its worker process has died, 2 times in a row"


@pytest.mark.slow
def test_without_an_answer_a_lost_job_is_an_error_and_the_executor_works_on(two_workers):
    with pytest.raises(JobLost, match="its worker process has died"):
        list(two_workers.map(jobs.die, [0]))
    assert list(two_workers.map(jobs.square, [3])) == [9]


def test_an_error_says_where_in_the_worker_it_arose(two_workers):
    with pytest.raises(UserError) as raised:
        list(two_workers.map(jobs.fail_at_two, [2]))
    assert raised.value.__notes__ == ["while testing"]
    assert isinstance(raised.value.__cause__, WorkerTraceback)
    assert "in fail_at_two" in str(raised.value.__cause__)


@pytest.mark.slow
def test_workers_compute_with_the_threads_they_are_given(two_workers):
    assert list(two_workers.map(jobs.threads, [0])) == [("1", "1", 1)]


@pytest.mark.slow
def test_results_of_an_iterator_left_early_do_not_turn_up_in_the_next(two_workers):
    assert next(two_workers.map(jobs.slow_square, range(6))) == 0
    assert list(two_workers.map(jobs.slow_square, range(10, 14))) == [100, 121, 144, 169]


def test_a_cluster_of_our_own_listens_on_the_loopback_alone_and_is_quiet(two_workers):
    list(two_workers.map(jobs.square, [1]))
    import ray

    assert [node["NodeManagerAddress"] for node in ray.nodes()] == ["127.0.0.1"]
    assert os.environ["RAY_USAGE_STATS_ENABLED"] == "0"
    found = subprocess.run(["ss", "-ltnpH"], capture_output=True, text=True, check=False).stdout
    of_ray = [line.split()[3] for line in found.splitlines() if "raylet" in line or "gcs_server" in line]
    assert all("127.0.0.1" in address for address in of_ray), of_ray


@pytest.mark.slow
def test_a_job_that_hangs_is_given_up_in_time(two_workers):
    executor = RayExecutor(
        RayExecutor.Config(workers=1, cpus_per_worker=0.5, timeout_s=0.5, attempts=1)
    )  # joins the same cluster
    started = time.monotonic()
    assert list(executor.map(jobs.HangAt(1), range(3))) == [
        0, "1 lost: it took longer than 0.5 s, 1 times in a row", 4
    ]  # fmt: skip
    assert time.monotonic() - started < 50
    executor.close()
    assert list(two_workers.map(jobs.square, [4])) == [16]


def test_more_than_any_node_has_is_refused_with_what_there_is(two_workers):
    list(two_workers.map(jobs.square, [1]))
    with pytest.raises(UserError, match=r"no node of the cluster has 1 CPU and 8 GPU .*") as raised:
        list(RayExecutor(RayExecutor.Config(gpus_per_worker=8)).map(jobs.square, [1]))
    assert "2 CPU and 0 GPU" in raised.value.faults[0].expected
    assert list(two_workers.map(jobs.square, [5])) == [25]


class KillsOnce:
    """Ends by SIGKILL, after the first generation of a study, the Ray workers that were started for it."""

    def __init__(self) -> None:
        self.others = workers_of(os.getpid())
        self.killed: set[int] = set()

    @hookimpl
    def tacos_generation_finished(self) -> None:
        if not self.killed:
            self.killed = workers_of(os.getpid()) - self.others
            for worker in self.killed:
                os.kill(worker, signal.SIGKILL)


def workers_of(process: int) -> set[int]:
    """Process ids of the Ray workers below a process."""
    found = set()
    for folder in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            name = (folder / "cmdline").read_bytes()
            line = [int(folder.name)]
            while line[-1] > 1 and line[-1] != process:
                line.append(int(Path(f"/proc/{line[-1]}/stat").read_text().rpartition(")")[2].split()[1]))
            if name.startswith(b"ray::Evaluator") and line[-1] == process:
                found.add(line[0])
    return found


def test_a_study_whose_worker_is_killed_midway_ends_as_one_that_runs_here(tmp_path):
    plugins = Plugins.discover()
    plugins.register(toy_plugin)
    local = run(toy_recipe(**LEARNER), plugins, tmp_path / "local")
    killer = KillsOnce()
    plugins.register(killer, name="kills once")
    spread = {"executor": {"use": "executor.ray", "workers": 2, "cpus_per_worker": 0.5}, **LEARNER}
    assert comparable(run(toy_recipe(**spread), plugins, tmp_path / "ray")) == comparable(local)
    assert killer.killed
    assert "it is tried again" in (tmp_path / "ray" / "log.txt").read_text()


def test_a_cluster_that_does_not_answer_is_an_error_that_says_what_to_do(monkeypatch, tmp_path):
    import ray

    monkeypatch.setattr(ray, "is_initialized", lambda: False)  # as in a process of its own
    (tmp_path / "ray").mkdir()
    (tmp_path / "ray" / "ray_current_cluster").write_text("127.0.0.1:9")  # of one that has died
    monkeypatch.setenv("RAY_TMPDIR", str(tmp_path))
    monkeypatch.delenv("RAY_ADDRESS", raising=False)
    refused = "no Ray cluster answers at '127.0.0.1:9': .*Connection refused"
    for address, said in (("127.0.0.1:9", refused), ("auto", refused), ("nowhere", "this is no address")):
        executor = RayExecutor(RayExecutor.Config(address=address))
        with pytest.raises(UserError, match=said) as raised:
            list(executor.map(jobs.square, [1]))
        assert "ray start --head" in raised.value.faults[0].remedy


@pytest.mark.parametrize(
    ("needs", "node", "count"),
    [
        (Needs(1, 0), {"CPU": 16.0}, 16),
        (Needs(2, 0.5), {"CPU": 16.0, "GPU": 1.0}, 2),
        (Needs(1, 1), {"CPU": 16.0}, 0),
        (Needs(0.1, 0), {"CPU": 0.3}, 3),
        (Needs(1, 0), {"memory": 1e9}, 0),
    ],
)
def test_workers_are_counted_by_what_is_scarce(needs, node, count):
    assert needs.fits_into(node) == count
