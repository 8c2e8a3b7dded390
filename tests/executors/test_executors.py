"""Executors: order, equality, errors, and workers that never outlive their use."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from tacos_framework.errors import UserError
from tacos_plugins.executors import affinity
from tacos_plugins.executors.local import LocalExecutor
from tacos_plugins.executors.outcomes import JobLost, WorkerTraceback
from tacos_plugins.executors.process import ProcessExecutor
from tests.executors import jobs

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def two_workers() -> Iterator[ProcessExecutor]:
    executor = ProcessExecutor(ProcessExecutor.Config(workers=2))
    yield executor
    executor.close()


def wait_until(condition, what: str, seconds: float = 20.0) -> None:
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, f"gave up waiting until {what}"
        time.sleep(0.02)


def gone(pid: int) -> bool:
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except FileNotFoundError:
        return True
    return state == "Z"  # ended; whoever adopted it has not looked yet


def test_local_evaluates_only_what_is_asked_for():
    results = LocalExecutor(LocalExecutor.Config()).map(jobs.fail_at_two, [0, 1, 2])
    assert [next(results), next(results)] == [0, 1]


def test_the_function_travels_once_per_worker_and_keeps_what_it_caches(tmp_path):
    executor = ProcessExecutor(ProcessExecutor.Config(workers=1))
    counting = jobs.Counting(tmp_path)
    assert list(executor.map(counting, range(3))) == [1, 2, 3]
    assert list(executor.map(counting, range(2))) == [4, 5]
    assert len(list(tmp_path.iterdir())) == 1
    executor.close()


def test_workers_compute_with_the_threads_they_are_given(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    monkeypatch.delenv("LP_NUM_THREADS", raising=False)
    executor = ProcessExecutor(ProcessExecutor.Config(workers=1))
    assert list(executor.map(jobs.threads, [0])) == [("1", "1", 1)]
    executor.close()
    assert os.environ["OMP_NUM_THREADS"] == "7"
    assert "LP_NUM_THREADS" not in os.environ


def test_a_worker_that_dies_is_replaced_and_its_job_tried_once_more(two_workers, tmp_path):
    jobs_of_trouble = jobs.DieOnFirstAttempt(tmp_path, at=2)
    assert list(two_workers.map(jobs_of_trouble, range(5))) == [0, 1, 4, 9, 16]
    assert len(list(tmp_path.iterdir())) == 1


@pytest.mark.parametrize(
    ("how", "said"),
    [
        ("killed", "was ended by SIGKILL (most often because memory ran out)"),
        ("segfault", "was ended by SIGSEGV"),
        ("exit", "ended with status 3"),
    ],
)
def test_a_job_whose_worker_dies_twice_is_answered_for_and_the_others_go_on(two_workers, how, said):
    results = list(two_workers.map(jobs.DieAt(2, how), range(5)))
    assert results[:2] + results[3:] == [0, 1, 9, 16]
    assert results[2] == f"2 lost: its worker process {said}, 2 times in a row"


def test_without_an_answer_a_lost_job_is_an_error_and_the_executor_works_on():
    executor = ProcessExecutor(ProcessExecutor.Config(workers=1))
    with pytest.raises(JobLost, match="SIGKILL"):
        list(executor.map(jobs.die, [0]))
    assert list(executor.map(jobs.square, [3])) == [9]
    executor.close()


def test_a_job_that_hangs_is_given_up_in_time(tmp_path):
    executor = ProcessExecutor(ProcessExecutor.Config(workers=2, timeout_s=0.4))
    started = time.monotonic()
    results = list(executor.map(jobs.HangAt(1), range(4)))
    assert results == [0, "1 lost: it took longer than 0.4 s, 2 times in a row", 4, 9]
    assert time.monotonic() - started < 20
    executor.close()


def test_without_a_limit_a_hanging_job_is_given_up_by_what_others_took(monkeypatch):
    monkeypatch.setattr(affinity, "GRACE_S", 0.3)
    executor = ProcessExecutor(ProcessExecutor.Config(workers=2))
    *_, hung, _ = executor.map(jobs.HangAt(3), range(5))
    assert hung.startswith("3 lost: it took longer than ")
    assert hung.endswith("far longer than any before it (timeout_s says how long it may), 2 times in a row")
    executor.close()


def test_the_time_jobs_may_take_follows_from_the_longest_and_is_tenfold_for_a_second_try():
    times = affinity.JobTimes()
    assert times.generous_s(1) == float("inf")
    times.saw(3.0, made="first")
    times.saw(1.0, made="nothing")
    assert times.generous_s(1) == 20 * 3.0 + 60
    assert times.generous_s(2) == 10 * times.generous_s(1)


@pytest.mark.parametrize(
    ("limits", "processes"), [({}, 1), ({"tasks_per_worker": 2}, 3), ({"max_memory_mib": 1}, 6)]
)
def test_workers_that_are_worn_are_replaced(limits, processes):
    executor = ProcessExecutor(ProcessExecutor.Config(workers=1, **limits))
    pids = list(executor.map(jobs.process_id, range(6)))
    assert len(set(pids)) == processes
    executor.close()
    for pid in pids:
        wait_until(lambda pid=pid: gone(pid), f"worker {pid} ends")


def test_an_error_says_where_in_the_worker_it_arose(two_workers):
    with pytest.raises(UserError) as raised:
        list(two_workers.map(jobs.fail_at_two, [2]))
    assert isinstance(raised.value.__cause__, WorkerTraceback)
    assert "in fail_at_two" in str(raised.value.__cause__)


@pytest.mark.parametrize(
    ("function", "what"),
    [(jobs.give_a_generator, "a generator"), (jobs.raise_what_does_not_come_back, "TwoArguments")],
)
def test_what_cannot_travel_is_an_error_that_says_so(two_workers, function, what):
    with pytest.raises(RuntimeError, match=f"{what}.* cannot travel between processes"):
        list(two_workers.map(function, [0]))


def test_results_of_an_iterator_left_early_do_not_turn_up_in_the_next(two_workers):
    for _ in range(3):
        assert next(two_workers.map(jobs.slow_square, range(6))) == 0
        assert list(two_workers.map(jobs.slow_square, range(10, 14))) == [100, 121, 144, 169]


def test_a_worker_that_cannot_start_is_an_error_not_a_lost_job(monkeypatch, tmp_path):
    (tmp_path / "sitecustomize.py").write_text("import os\n\nos._exit(7)\n")
    executor = ProcessExecutor(ProcessExecutor.Config(workers=1))
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    with pytest.raises(RuntimeError, match="a worker cannot start: its worker process ended with status"):
        list(executor.map(jobs.square, [3]))
    executor.close()


def test_close_does_not_wait_for_running_jobs(tmp_path):
    executor = ProcessExecutor(ProcessExecutor.Config(workers=1))
    started = time.monotonic()

    def close_once_busy() -> None:
        wait_until(lambda: list(tmp_path.iterdir()), "the job runs")
        executor.close()

    closing = threading.Thread(target=close_once_busy)
    closing.start()
    with pytest.raises(RuntimeError, match="closed while jobs were running"):
        next(executor.map(jobs.Hang(tmp_path), [0]))
    closing.join()
    executor.close()  # twice is fine
    worker = int(next(tmp_path.iterdir()).name)
    wait_until(lambda: gone(worker), "the worker ends")
    assert time.monotonic() - started < 20


STUDY = """
import sys
from pathlib import Path
from tacos_plugins.executors.process import ProcessExecutor
from tests.executors.jobs import Hang

if __name__ == "__main__":
    executor = ProcessExecutor(ProcessExecutor.Config(workers=2))
    try:
        list(executor.map(Hang(Path(sys.argv[1])), range(4)))
    except KeyboardInterrupt:
        print("interrupted")
    finally:
        executor.close()
"""


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGKILL])
def test_no_worker_outlives_the_parent(tmp_path, how):
    script = tmp_path / "study.py"
    script.write_text(STUDY)
    pids = tmp_path / "pids"
    pids.mkdir()
    parent = subprocess.Popen(
        [sys.executable, str(script), str(pids)],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    wait_until(lambda: len(list(pids.iterdir())) == 2, "both workers run")
    if how == signal.SIGINT:
        os.killpg(parent.pid, how)  # as a terminal does: to the parent and to every worker
    else:
        os.kill(parent.pid, how)
    said, complaints = parent.communicate(timeout=20)
    if how == signal.SIGINT:
        assert said == "interrupted\n"
        assert complaints == ""
        assert parent.returncode == 0
    for worker in pids.iterdir():
        wait_until(lambda worker=worker: gone(int(worker.name)), f"worker {worker.name} ends")


@pytest.mark.parametrize(("way", "named"), [("-", "standard input"), ("/dev/fd/0", "/dev/fd/0")])
@pytest.mark.parametrize("guard", ["if __name__ == '__main__':", "if True:"])
def test_a_script_that_cannot_be_read_twice_is_told_to_be_saved(way: str, named: str, guard: str) -> None:
    """A guard would not help it, so that none is asked for."""
    script = (
        "from tacos_plugins.executors.process import ProcessExecutor\n"
        f"{guard}\n"
        "    list(ProcessExecutor(ProcessExecutor.Config(workers=1)).map(abs, [1]))\n"
    )
    said = subprocess.run([sys.executable, way], input=script, capture_output=True, text=True, check=False)
    assert said.returncode == 1
    assert f"the script that starts them, and {named} cannot be read twice" in said.stderr
    assert "Save the script as a file and run that, or set executor: {use: executor.local}" in said.stderr
    assert "keep their work below" not in said.stderr
