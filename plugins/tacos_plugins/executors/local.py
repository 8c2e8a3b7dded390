"""Evaluation in this process."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

from tacos_framework import Settings

Job = TypeVar("Job")
Result = TypeVar("Result")


class LocalExecutor:
    """Evaluates jobs one after another, here: nothing is copied, and a debugger sees everything.

    >>> list(LocalExecutor(LocalExecutor.Config()).map(abs, [-1, 2, -3]))
    [1, 2, 3]
    """

    class Config(Settings):
        """No settings."""

    def __init__(self, config: Config) -> None:
        self.config = config

    def map(self, evaluate: Callable[[Job], Result], jobs: Sequence[Job]) -> Iterator[Result]:
        """The results in the order of the jobs, each evaluated when it is asked for."""
        return map(evaluate, jobs)

    def close(self) -> None:
        """Nothing to let go of."""
