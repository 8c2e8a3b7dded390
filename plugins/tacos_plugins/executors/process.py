"""Evaluation in worker processes of this machine."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from multiprocessing.reduction import ForkingPickler
from typing import Any, TypeVar

from tacos_framework import Settings, setting
from tacos_plugins.executors.outcomes import results
from tacos_plugins.executors.pool import Limits, Pool

Job = TypeVar("Job")
Result = TypeVar("Result")

THREAD_LIMITS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "LP_NUM_THREADS")
"""Environment variables that numerical libraries and the llvmpipe rasterizer read once, when they start."""

MEMORY_IS_KEPT = {"MALLOC_MMAP_MAX_": "0", "MALLOC_TRIM_THRESHOLD_": str(2**31)}
"""Lets the C library (glibc) keep what is freed, up to 2 GiB, for the next image: to get the memory of one of
twelve megapixels anew from the system takes about as long as to fill it several times."""


class ProcessExecutor:
    """Evaluates jobs in processes that live until `close`, with the same results as in this process.

    Workers are *spawned*: a process that owns a GL context must not fork. Each receives the pickled
    ``evaluate`` once, and keeps it, with whatever it caches, for all jobs to come; a different ``evaluate``
    gets fresh workers. Each worker computes with a few threads only, so that workers do not fight for cores.

    A worker that dies (a driver crashes, memory runs out) or takes longer than ``timeout_s`` is replaced and
    its job tried once more. When that fails too, the result is ``evaluate.lost(job, reason)``, or a `JobLost`
    is raised where ``evaluate`` has no such method. The other jobs go on meanwhile.

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
            None,
            help="Worker processes; by default one for each core this process may use.",
            ge=1,
            also=("jobs", "processes"),
        )
        threads: int = setting(1, help="Threads each worker may compute with.", ge=1)
        timeout_s: float | None = setting(
            None,
            help="Longest time for one candidate, worlds built for it included; .inf for any. By default "
            "20 times the longest seen so far, and a minute more; ten times that when it is tried again. "
            "A worker that takes longer is replaced, and the candidate tried once more.",
            unit="s",
            gt=0,
        )
        max_memory_mib: int | None = setting(
            None,
            help="Memory a worker may hold after a candidate; one that holds more is replaced.",
            unit="MiB",
            ge=1,
        )
        tasks_per_worker: int | None = setting(
            None, help="Candidates after which a worker is replaced, for components that leak.", ge=1
        )

    def __init__(self, config: Config) -> None:
        self.config = config
        self.workers = config.workers or len(os.sched_getaffinity(0))
        self._pool: Pool | None = None

    def map(self, evaluate: Callable[[Job], Result], jobs: Sequence[Job]) -> Iterator[Result]:
        """The results in the order of the jobs; those not begun are dropped when the iterator is left early.

        Raises
        ------
        JobLost
            When the worker of a job died or hung twice and ``evaluate`` has no answer to that.
        RuntimeError
            When the executor is closed meanwhile, or a worker cannot start.
        """
        if not jobs:
            return
        try:
            yield from results(evaluate, jobs, self._pool_for(evaluate).outcomes(jobs))
        except KeyboardInterrupt:
            self.close()
            raise

    def close(self) -> None:
        """End all workers at once."""
        pool, self._pool = self._pool, None  # first let go, so that two threads may close at a time
        if pool is not None:
            pool.close()

    def _pool_for(self, evaluate: Callable[[Any], Any]) -> Pool:
        """The pool whose workers hold this very function, as told by its pickled bytes."""
        payload = bytes(ForkingPickler.dumps(evaluate))
        if self._pool is not None and self._pool.payload != payload:
            self.close()
        if self._pool is None:
            config = self.config
            limits = Limits(config.timeout_s, config.max_memory_mib, config.tasks_per_worker)
            threads = dict.fromkeys(THREAD_LIMITS, str(config.threads))
            self._pool = Pool(payload, self.workers, limits, config.threads, {**MEMORY_IS_KEPT, **threads})
        return self._pool
