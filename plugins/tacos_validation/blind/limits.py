"""A bound on the time of a job, kept in the process that does it."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType


class TimeIsUp(BaseException):
    """Raised in the midst of a job; no `Exception`, lest a guard of components take it for their error."""


@contextmanager
def time_limit(seconds: float | None) -> Iterator[None]:
    """Raise `TimeIsUp` in the body after so much time.

    It works in the main thread, where systems tell of timers; elsewhere the body goes on, and what runs the
    process bounds it.

    Parameters
    ----------
    seconds
        The longest time; None for any [s].
    """
    bounded = hasattr(signal, "setitimer") and threading.current_thread() is threading.main_thread()
    if seconds is None or not bounded:
        yield
        return

    def stop(number: int, frame: FrameType | None) -> None:
        raise TimeIsUp

    before = signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
