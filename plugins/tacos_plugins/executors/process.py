"""Evaluation in worker processes of this machine."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing.connection import Connection
from multiprocessing.reduction import ForkingPickler
from typing import Any, TypeVar

from tacos_framework.settings import Settings, setting
from tacos_plugins.executors import worker

Job = TypeVar("Job")
Result = TypeVar("Result")

THREAD_LIMITS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "LP_NUM_THREADS")
"""Environment variables that numerical libraries and the llvmpipe rasterizer read once, when they start."""


class ProcessExecutor:
    """Evaluates jobs in processes that live until `close`, with the same results as in this process.

    Workers are *spawned*: a process that owns a GL context must not fork. Each receives the pickled
    ``evaluate`` once, and keeps it, with whatever it caches, for all jobs to come; a different ``evaluate``
    gets fresh workers. Each worker computes with a few threads only, so that workers do not fight for cores.

    `close`, Ctrl-C and the death of this process end all workers at once, whatever they are doing.

    Examples
    --------
    >>> executor = ProcessExecutor(ProcessExecutor.Config(workers=2))
    >>> list(executor.map(abs, [-1, 2, -3]))
    [1, 2, 3]
    >>> executor.close()
    """

    class Config(Settings):
        """Settings of the executor."""

        workers: int | None = setting(
            None, help="Worker processes; by default one for each core this process may use.", ge=1
        )
        threads: int = setting(1, help="Threads each worker may compute with.", ge=1)

    def __init__(self, config: Config) -> None:
        self.config = config
        self.workers = config.workers or len(os.sched_getaffinity(0))
        self._pool: _Pool | None = None

    def map(self, evaluate: Callable[[Job], Result], jobs: Sequence[Job]) -> Iterator[Result]:
        """The results in the order of the jobs; those not begun are dropped when the iterator is left early.

        Raises
        ------
        BrokenProcessPool
            When a worker died, with a note on the usual reason.
        """
        if not jobs:
            return
        futures: list[Future[Result]] = []
        try:
            with _environment(dict.fromkeys(THREAD_LIMITS, str(self.config.threads))):
                pool = self._pool_for(evaluate)
                futures = [pool.submit(job) for job in jobs]  # spawns workers, which inherit the variables
            for future in futures:
                yield future.result()
        except KeyboardInterrupt:
            self.close()
            raise
        except BrokenProcessPool as error:
            error.add_note(
                "A worker process ended abruptly, most often because memory ran out. There were "
                f"{self.workers} workers: try fewer, or smaller images."
            )
            self.close()
            raise
        finally:
            for future in futures:
                future.cancel()

    def close(self) -> None:
        """End all workers at once."""
        pool, self._pool = self._pool, None  # first let go, so that two threads may close at a time
        if pool is not None:
            pool.close()

    def _pool_for(self, evaluate: Callable[[Any], Any]) -> _Pool:
        """The pool whose workers hold this very function, as told by its pickled bytes."""
        payload = bytes(ForkingPickler.dumps(evaluate))
        if self._pool is not None and self._pool.payload != payload:
            self.close()
        if self._pool is None:
            self._pool = _Pool(payload, self.workers, self.config.threads)
        return self._pool


class _Pool:
    """Worker processes that hold one function, and the lifeline that keeps them alive."""

    def __init__(self, payload: bytes, workers: int, threads: int) -> None:
        self.payload = payload
        spawn = multiprocessing.get_context("spawn")
        self._worker_end: Connection
        self._worker_end, self._lifeline = spawn.Pipe(duplex=False)
        self._processes = ProcessPoolExecutor(
            workers,
            mp_context=spawn,
            initializer=worker.start,
            initargs=(payload, self._worker_end, threads),
        )

    def submit(self, job: Any) -> Future[Any]:
        return self._processes.submit(worker.evaluate, job)

    def close(self) -> None:
        self._lifeline.close()
        self._processes.shutdown(wait=True, cancel_futures=True)
        self._worker_end.close()


@contextmanager
def _environment(variables: dict[str, str]) -> Iterator[None]:
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
