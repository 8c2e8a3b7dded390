"""A bound on the processor time of a job, kept in the process that does it."""

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
    """Raise `TimeIsUp` in the body after so much processor time.

    Processor time, so that answers do not hang on what else the machine does; a job that waits forever is for
    the time limit of its executor. It works in the main thread, where systems tell of timers; elsewhere the
    body goes on.

    `seconds`: the longest time, of all threads of this process together; None for any [s].
    """
    bounded = hasattr(signal, "setitimer") and threading.current_thread() is threading.main_thread()
    if seconds is None or not bounded:
        yield
        return

    def stop(number: int, frame: FrameType | None) -> None:
        raise TimeIsUp

    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)
