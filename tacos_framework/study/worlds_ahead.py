"""Worlds of the test, built while workers would wait for the last candidate of a round."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import chain, islice, repeat
from typing import Any, ClassVar, TypeVar

from tacos_framework.contracts import Executor, ExecutorBase, optional
from tacos_framework.settings import Settings
from tacos_framework.simulation import BuildJob, EpisodeSpec

OFFERED = 3
"""How often a world is offered. Whether it was begun nobody tells, and to look at one that is there takes a
frame each time: a search of thousands of rounds must not go on with that."""

Job = TypeVar("Job")
Result = TypeVar("Result")


class BuildingAhead:
    """An executor that is given, behind the jobs of each round, worlds to build that are needed later.

    A worker takes one up when no other job waits, and keeps it on disk and at hand. Nobody waits for it: the
    round ends with its last real job, and what was not begun then is offered again in a later round, a few
    times.

    - `worlds`: the episodes whose worlds are needed; none leaves everything as it is.
    """

    Config: ClassVar[type[Settings]] = Settings

    def __init__(self, executor: Executor, worlds: Sequence[EpisodeSpec]) -> None:
        self._executor = executor
        self._worlds = chain.from_iterable(repeat(tuple(worlds), OFFERED))

    @property
    def workers(self) -> int:
        return int(optional(self._executor, ExecutorBase, "workers"))

    def map(self, evaluate: Callable[[Job], Result], jobs: Sequence[Job]) -> Iterator[Result]:
        ahead: Sequence[Any] = list(self._ahead(jobs)) if self.workers > 1 else []
        results = iter(self._executor.map(evaluate, [*jobs, *ahead]))
        yield from islice(results, len(jobs))
        if not ahead:
            yield from results  # to the end: there an executor cleans up

    def _ahead(self, jobs: Sequence[Any]) -> Iterator[BuildJob]:
        """A world for each worker that has no job, and one for the worker that is done first."""
        values: Mapping[str, Any] | None = next((job.values for job in jobs), None)
        if values is not None:
            for world in islice(self._worlds, max(1, self.workers - len(jobs))):
                yield BuildJob(values, world)

    def close(self) -> None:
        self._executor.close()
