"""Progress of a phase and an estimate of the time left, said now and then in the log of the run."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from datetime import timedelta

from tacos_framework.errors import printable
from tacos_framework.simulation import Evaluation
from tacos_framework.study.progress import Progress

log = logging.getLogger(__name__)

EVERY_S = 60.0
"""The log is told at most so often [s]."""


class Pace:
    """Counts what is done of a phase.

    - `total`: how many candidates or steps it will take; None where nobody knows.
    - `clock`: seconds since any moment.

    >>> now_s = 0.0
    >>> pace = Pace("Designing", 4, clock=lambda: now_s)
    >>> print(pace)
    Designing: 0 of 4 done
    >>> for now_s in (90.0, 100.0):
    ...     pace.done += 1
    ...     print(pace)
    Designing: 1 of 4 done
    Designing: 2 of 4 done, about 0:00:20 left
    """

    def __init__(self, title: str, total: int | None, clock: Callable[[], float] = time.monotonic):
        self.title = printable(title)
        self.total = total
        self._clock = clock
        self._seen: list[tuple[int, float]] = [(0, clock())]

    @property
    def done(self) -> int:
        return self._seen[-1][0]

    @done.setter
    def done(self, count: int) -> None:
        self._seen.append((count, self._clock()))

    def __str__(self) -> str:
        """Share done, and the time left at the pace of the last half of the steps or, if later, of the time.

        The first is no pace: it reads and lights the world, and made estimates of up to 15 times too much.
        What is taken from an earlier run is none either: it takes no time.
        """
        if self.total is None or self.done > self.total:  # an estimate that what is scored again exceeds
            return f"{self.title}: {self.done} done"
        so_far = f"{self.title}: {self.done} of {self.total} done"
        left = self.total - self.done
        if self.done < 2 or left <= 0:
            return so_far
        now_s = self._clock()
        halfway_s = (self._seen[0][1] + now_s) / 2
        first, since_s = next(
            (count, s) for count, s in reversed(self._seen) if count <= self.done // 2 or s <= halfway_s
        )
        if not first:
            return so_far
        left_s = (now_s - since_s) / max(self.done - first, 1) * left
        return f"{so_far}, about {timedelta(seconds=round(left_s))} left"


class Logged:
    """Hands on what it is told, and says in the log how far the work is, whether anybody watches or not."""

    def __init__(self, shown: Progress, clock: Callable[[], float] = time.monotonic):
        self._shown = shown
        self._clock = clock
        self._said_s = clock()
        self._pace: Pace | None = None

    def phase(self, title: str, candidates: int | None) -> None:
        self._shown.phase(title, candidates)
        self._pace = Pace(title, candidates, self._clock)
        log.info("%s", self._pace.title)
        self._said_s = self._clock()

    def evaluated(self, evaluation: Evaluation) -> None:
        self._shown.evaluated(evaluation)
        self._count()

    def best(self, best: Evaluation | None) -> None:
        self._shown.best(best)

    def step(self, note: str = "") -> None:
        self._shown.step(note)
        self._count()

    def _count(self) -> None:
        if self._pace is None:
            return
        self._pace.done += 1
        if self._clock() - self._said_s >= EVERY_S:
            log.info("%s", str(self._pace))  # now: who reads records later reads what was true then
            self._said_s = self._clock()
