"""Tells how far a diagnosis is: on the terminal, and in the log of a run that nobody watches."""

from __future__ import annotations

import logging
import math
import threading
import time
from collections.abc import Callable
from types import TracebackType
from typing import Self

from tacos_framework import Progress
from tacos_gap.answer.diagnosis import CLOSED_FORMS
from tacos_gap.attribution.selection import RIVALS
from tacos_report.quantities import duration

log = logging.getLogger(__name__)

EVERY_S = 20.0
"""At most so long nothing is said [s]."""

DONE_AT = {
    CLOSED_FORMS: 0.0,
    "measuring the captures": 0.0,
    "trying effects": 0.1,
    RIVALS: 0.75,
    "closure of the gap": 0.9,
}
"""Share of the time that is gone as a stage begins."""

DONE_AT_FIRST_CAUSE = 0.4
LEFT_AFTER_ANOTHER = 0.7
"""Each further cause leaves this share of what was left: how many there will be is not known."""


def done_after(share: float, text: str) -> float:
    """Share of the time that is gone once a stage begins; `share` was gone before.

    >>> done_after(0.0, "trying effects"), done_after(0.1, "vignetting"), done_after(0.5, "vignetting + prnu")
    (0.1, 0.4, 0.65)
    """
    if text in DONE_AT:
        return max(share, DONE_AT[text])
    if share < DONE_AT_FIRST_CAUSE:
        return DONE_AT_FIRST_CAUSE
    return round(1 - (1 - share) * LEFT_AFTER_ANOTHER, 3)


def time_left_s(elapsed_s: float, share: float) -> float | None:
    return None if share <= 0 else elapsed_s * (1 - share) / share


def roughly(seconds: float) -> str:
    """An estimate, no finer than it is.

    >>> roughly(42.0), roughly(530.0)
    ('50 s', '9 min')
    """
    return f"{math.ceil(seconds / 60)} min" if seconds > 90 else f"{10 * math.ceil(seconds / 10)} s"


class Telling:
    """Says each stage as it begins, and now and then that it is still at work.

    A context manager: it speaks from another thread until it is left.

    `every_s`: longest silence [s]. `clock`: seconds since any moment.
    """

    def __init__(
        self, progress: Progress, every_s: float = EVERY_S, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._progress = progress
        self._every_s = every_s
        self._clock = clock
        self._began_s = clock()
        self._at, self._share, self._stage_began_s = "", 0.0, self._began_s
        self._over = threading.Event()
        self._speaker = threading.Thread(target=self._speak, daemon=True)

    def __enter__(self) -> Self:
        self._speaker.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._over.set()
        self._speaker.join()

    def __call__(self, text: str) -> None:
        self._share = done_after(self._share, text)
        self._at, self._stage_began_s = text, self._clock()
        self._say(text)

    def _speak(self) -> None:
        while not self._over.wait(self._every_s):
            self._say(f"still {self._at}")

    def _say(self, text: str) -> None:
        now = self._clock()
        elapsed_s = now - self._began_s
        # within a stage the share stands still: what was left as it began runs out meanwhile
        left_s = time_left_s(self._stage_began_s - self._began_s, self._share)
        told = f"{text} ({duration(elapsed_s)} so far"
        if left_s is not None and (rest_s := left_s - (now - self._stage_began_s)) > 0:
            told += f", about {roughly(rest_s)} left"
        log.info("%s)", told)
        self._progress.step(f"{told})")
