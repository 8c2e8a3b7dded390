"""Outcomes of jobs in other processes, on their way to the caller."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TypeVar

from tacos_plugins.executors.worker import Answer

Job = TypeVar("Job")
Result = TypeVar("Result")


@dataclass(frozen=True)
class Lost:
    """A job without an outcome: its worker died or hung, each time it was tried."""

    reason: str


class JobLost(RuntimeError):
    """The worker of a job died or hung each time the job was tried."""


class WorkerTraceback(Exception):
    """Traceback of an error in a worker, as text: the cause of the error as it arrives here."""

    def __str__(self) -> str:
        return f"in a worker process\n\n{self.args[0]}"


def results(
    evaluate: Callable[[Job], Result], jobs: Sequence[Job], outcomes: Iterator[Answer | Lost]
) -> Iterator[Result]:
    """The results of jobs from their outcomes, in order.

    Raises `JobLost` for a job that was lost, where ``evaluate`` has no answer to that (a method ``lost``).
    What a job raised leaves it unchanged.
    """
    for job, outcome in zip(jobs, outcomes, strict=True):
        if isinstance(outcome, Lost):
            yield _without_result(evaluate, job, outcome.reason)
        elif outcome.error is not None:
            raise outcome.error from WorkerTraceback(outcome.traceback)
        else:
            yield outcome.value


def _without_result(evaluate: Callable[[Job], Result], job: Job, reason: str) -> Result:
    lost: Callable[[Job, str], Result] | None = getattr(evaluate, "lost", None)
    if lost is None:
        raise JobLost(reason)
    return lost(job, reason)
