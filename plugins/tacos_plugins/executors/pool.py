"""Worker processes that may die, hang or leak, and the results that come out of them all the same."""

from __future__ import annotations

import atexit
import logging
import multiprocessing
import os
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing.connection import wait
from multiprocessing.reduction import ForkingPickler
from pathlib import Path
from typing import Any

from tacos_framework import Fault, UserError
from tacos_plugins.executors import worker
from tacos_plugins.executors.job_pool import JobPool
from tacos_plugins.executors.worker_process import WorkerProcess

log = logging.getLogger(__name__)

ATTEMPTS = 2
"""Tries of a job whose worker dies or hangs."""


MOST_FAILED_STARTS = 3
"""Number of workers in a row that may be killed before they are ready, as by a system short of memory."""


@dataclass(frozen=True)
class Limits:
    """Limits beyond which a worker is replaced."""

    job_s: float | None = None
    """Longest time of a job [s]; None for one that follows from those seen (`JobTimes.generous_s`)."""
    resident_mib: float | None = None
    """Memory after a job [MiB]; None for any."""
    jobs: int | None = None
    """Number of jobs; None for any."""


class Pool(JobPool[WorkerProcess]):
    """Worker processes that hold one function.

    - `limits`: when a worker is replaced.
    - `threads`: threads each may compute with.
    - `environment`: environment variables workers start with, beside those of this process.
    """

    def __init__(
        self, payload: bytes, workers: int, limits: Limits, threads: int, environment: Mapping[str, str]
    ) -> None:
        super().__init__(payload, workers, ATTEMPTS)
        self._limits = limits
        self._threads = threads
        self._environment = environment
        self._context = multiprocessing.get_context("spawn")
        atexit.register(self.close)  # ahead of multiprocessing's own, which would wait for workers
        self._started = 0
        self._failed_starts = 0
        self._closed = False

    def close(self) -> None:
        self._closed = True
        atexit.unregister(self.close)
        for each in self._workers:
            each.process.kill()
        for each in self._workers:
            each.process.join()
            each.log.close()

    # ------------------------------------------------------------------------------------------------------

    def _start(self) -> WorkerProcess:
        if self._started == 0 and (script := _script_that_is_no_file()) is not None:
            raise UserError(
                Fault(
                    "executor",
                    f"worker processes import the script that starts them, and {script} cannot be read twice",
                    "a script in a file",
                    "Save the script as a file and run that, or set executor: {use: executor.local}.",
                )
            )
        self._started += 1
        with _environment(self._environment):
            return WorkerProcess(self._started, self._context, self.payload, self._threads)

    def _send(self, each: WorkerProcess, job: Any) -> bool:
        return each.send(job)

    def _collect(self) -> None:
        soonest = min(self._deadline(each) for each in self._workers)
        patience = None if soonest == float("inf") else max(0.0, soonest - time.monotonic())
        events: list[Any] = [each.channel for each in self._workers]
        events += [each.process.sentinel for each in self._workers]
        wait(events, patience)
        if self._closed:
            raise RuntimeError("the executor was closed while jobs were running")
        for each in list(self._workers):
            try:
                message = each.answer()
            except (EOFError, ConnectionResetError):
                self._replace(each, each.how_it_ended())
                continue
            if message is not None:
                self._take(each, message)
            elif time.monotonic() > (deadline := self._deadline(each)):
                each.process.kill()
                how = f"it took longer than {deadline - each.began_s:.3g} s"
                if self._limits.job_s is None:
                    how += ", far longer than any before it (timeout_s says how long it may)"
                self._replace(each, how)

    def _deadline(self, each: WorkerProcess) -> float:
        """When a worker counts as hung; the first jobs are given all the time they need."""
        if each.task is None:
            return float("inf")
        return each.began_s + (self._limits.job_s or self._times.generous_s(each.task.attempt))

    def _take(self, each: WorkerProcess, message: bytes) -> None:
        """Keep an answer, and let its worker go where that has come to its limits."""
        task, each.task = each.task, None
        each.ready = True
        self._failed_starts = 0
        answer: worker.Answer = ForkingPickler.loads(message)
        if task is None:
            return
        each.jobs_done += 1
        self._finished(each, task, answer)
        limits = self._limits
        worn = limits.jobs is not None and each.jobs_done >= limits.jobs
        if limits.resident_mib is not None and answer.resident_mib > limits.resident_mib:
            log.info("a worker holds %.0f MiB and is replaced", answer.resident_mib)
            worn = True
        if worn:
            each.channel.send_bytes(worker.LEAVE)
            self._workers.remove(each)

    def _replace(self, each: WorkerProcess, how: str) -> None:
        """Forget a worker that is lost; try its job again, or give it up."""
        self._workers.remove(each)
        each.log.close()
        if not each.ready:
            self._failed_starts += 1
            if (each.process.exitcode or 0) < 0 and self._failed_starts <= MOST_FAILED_STARTS:
                log.warning("a worker did not come to start: %s; another takes its place", how)
                return
            error = RuntimeError(f"a worker cannot start: {how}")
            error.add_note(
                "Scripts that use worker processes keep their work below 'if __name__ == \"__main__\":'."
            )
            raise error
        self._try_again(each.task, how)


def _script_that_is_no_file() -> str | None:
    """The script of this process, where a new process could not run it again: standard input, or a pipe."""
    main = sys.modules.get("__main__")
    script = getattr(main, "__file__", None)
    if script is None or getattr(main, "__spec__", None) is not None or Path(script).is_file():
        return None
    return "standard input" if script == "<stdin>" else str(script)


@contextmanager
def _environment(variables: Mapping[str, str]) -> Iterator[None]:
    """Set environment variables for the processes started inside."""
    before = {name: os.environ.get(name) for name in variables}
    os.environ.update(variables)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
