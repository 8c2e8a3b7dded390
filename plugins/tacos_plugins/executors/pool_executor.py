"""An executor whose workers hold one function."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from multiprocessing.reduction import ForkingPickler
from typing import Any, TypeVar

from tacos_plugins.executors.job_pool import JobPool
from tacos_plugins.executors.outcomes import results

Job = TypeVar("Job")
Result = TypeVar("Result")


class PoolExecutor(ABC):
    """Keeps a pool as long as jobs are for the same function; a different one gets fresh workers."""

    def __init__(self) -> None:
        self._pool: JobPool[Any] | None = None

    def map(self, evaluate: Callable[[Job], Result], jobs: Sequence[Job]) -> Iterator[Result]:
        """The results in the order of the jobs; those not begun are dropped when the iterator is left early.

        Raises `JobLost` when the worker of a job was lost each time and ``evaluate`` has no answer to that.
        Raises `RuntimeError` when the executor is closed meanwhile, or a worker cannot start.
        """
        if not jobs:
            return
        try:
            yield from results(evaluate, jobs, self._pool_for(evaluate).outcomes(jobs))
        except KeyboardInterrupt:
            self.close()
            raise

    def close(self) -> None:
        pool, self._pool = self._pool, None  # first let go, so that two threads may close at a time
        if pool is not None:
            pool.close()

    @abstractmethod
    def _new_pool(self, payload: bytes) -> JobPool[Any]:
        """A pool whose workers hold a pickled function."""

    def _pool_for(self, evaluate: Callable[[Any], Any]) -> JobPool[Any]:
        """The pool whose workers hold this very function, as told by its pickled bytes."""
        payload = bytes(ForkingPickler.dumps(evaluate))
        if self._pool is not None and self._pool.payload != payload:
            PoolExecutor.close(self)  # the workers alone: a cluster that was joined goes on
        if self._pool is None:
            self._pool = self._new_pool(payload)
        return self._pool
