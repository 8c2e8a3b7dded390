"""Where evaluations run."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import ClassVar, Protocol, TypeVar

from tacos_framework.settings import Settings

Job = TypeVar("Job")
Result = TypeVar("Result")


class Executor(Protocol):
    """Runs evaluations, here or elsewhere.

    A further member is optional:

    ``workers: int``
        How many jobs it runs at a time; work is cut into as many parts. 1 where it does not say.
    """

    Config: ClassVar[type[Settings]]

    def map(self, evaluate: Callable[[Job], Result], jobs: Sequence[Job]) -> Iterator[Result]:
        """The results in the order of the jobs, each as soon as it and those before it are there.

        `evaluate` can be pickled and keeps costly things (GL context, worlds) between calls in the process
        it runs in. An exception it raises comes out of the iterator unchanged. Where a process dies or hangs
        on a job whenever it is tried, the result is ``evaluate.lost(job, reason)`` if `evaluate` has that.
        """
        ...

    def close(self) -> None:
        """Let go of all workers; safe to call twice."""
        ...
