"""Evaluation by ``concurrent.futures``: the shape of an adapter to any engine that hands out futures."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import TypeVar

from tacos_framework import Settings, setting

Job = TypeVar("Job")
Result = TypeVar("Result")


class FuturesExecutor:
    """Submits every job to a pool and hands the results on in the order of the jobs.

    Workers are *spawned*: a process that owns a GL context must not fork.
    """

    class Config(Settings):
        workers: int = setting(2, help="Worker processes.", ge=1)

    def __init__(self, config: Config) -> None:
        self.config = config
        self.workers = config.workers
        self._pool: ProcessPoolExecutor | None = None

    def map(self, evaluate: Callable[[Job], Result], jobs: Sequence[Job]) -> Iterator[Result]:
        """The results in order; jobs not begun are dropped when the iterator is left early."""
        if self._pool is None:
            context = multiprocessing.get_context("spawn")
            self._pool = ProcessPoolExecutor(self.config.workers, mp_context=context)
        futures = [self._pool.submit(evaluate, job) for job in jobs]
        try:
            for future in futures:
                yield future.result()
        finally:
            for future in futures:
                future.cancel()

    def close(self) -> None:
        """Wait for what is being evaluated, then end the workers."""
        pool, self._pool = self._pool, None
        if pool is not None:
            pool.shutdown(cancel_futures=True)
