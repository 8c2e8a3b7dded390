"""Contract of what evaluations run in."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import ClassVar, Protocol, TypeVar

from tacos_framework.settings import Settings

Job = TypeVar("Job")
Result = TypeVar("Result")


class JobRunner(Protocol):
    """Runs evaluations, here or elsewhere: what a host may hand to `run` in place of a recipe's executor.

    `ExecutorBase` has an optional member.

    A job may have an attribute ``affinity: Hashable | None``: what it needs that is costly to make and is
    kept in the process that made it (a world, lit). Workers do well to be given jobs of an affinity they have
    had, but results never depend on it.
    """

    def map(self, evaluate: Callable[[Job], Result], jobs: Sequence[Job]) -> Iterator[Result]:
        """The results in the order of the jobs, each as soon as it and those before it are there.

        `evaluate` can be pickled and keeps costly things (GL context, worlds) between calls in the process
        it runs in. An exception it raises comes out of the iterator unchanged. Where a process dies or hangs
        on a job whenever it is tried, the result is ``evaluate.lost(job, reason)`` if `evaluate` has that.

        The iterator may be left early, and the executor used again at once: jobs not begun are dropped then,
        and nobody waits for those that were.

        The framework tells results by a key that each carries: a result too many, too few or of another call
        is an error, and another order is put right.
        """
        ...

    def close(self) -> None:
        """Let go of all workers; safe to call twice."""
        ...


class Executor(JobRunner, Protocol):
    """A `JobRunner` that recipes can name."""

    Config: ClassVar[type[Settings]]


class ExecutorBase:
    """Optional members of a `JobRunner`, with their defaults."""

    workers: int = 1
    """Number of jobs it runs at a time."""
