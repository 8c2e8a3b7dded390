"""Imports that do not end are ended."""

from __future__ import annotations

import math
import os
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from tacos_framework.errors import Fault, UserError
from tacos_framework.plugins.failures import WITHOUT_VARIABLE, say

LIMIT_VARIABLE = "TACOS_IMPORT_S"
"""Environment variable: the most processor time an import may take [s]."""

IMPORT_S = 60.0
"""What an import may take where the variable says nothing: torch takes less than ten [s]."""

CLOCK_PER_PROCESSOR_S = 10.0
"""How much longer an import may take by the clock: busy machines and slow disks are no faults."""

_LONGEST_S = 1e8  # what a timer takes: years
_RINGS = 3  # how often an import that catches everything is told to end
_SHORTEST_S = 0.01  # between two looks at the processor time, which grows slowly on a busy machine


class TookTooLong(BaseException):
    """An import took longer than it may. No `Exception`, lest the import catch it."""


@contextmanager
def bounded(plugin: str, processor_s: float) -> Iterator[None]:
    """Raise `TookTooLong` in a body that takes too long: in the main thread, where timers are heard of.

    A host whose own timer is running keeps it, and no bound.

    Parameters
    ----------
    plugin
        Whose import it is, for messages.
    processor_s
        The most processor time the body may take [s]; by the clock it may take longer, see `_Allowance`.
    """
    is_main = threading.current_thread() is threading.main_thread()
    if not is_main or not hasattr(signal, "setitimer") or signal.getitimer(signal.ITIMER_REAL)[0]:
        yield
        return
    allowed = _Allowance(processor_s)
    rings = 0

    # It rings when the time can be used up at the earliest, and waits on where it is not: a timer of
    # processor time would be one of all threads, and is what profilers take.
    def ring(number: int, frame: FrameType | None) -> None:
        nonlocal rings
        if left_s := allowed.left_s():
            signal.setitimer(signal.ITIMER_REAL, left_s)
            return
        rings += 1
        if rings > _RINGS:
            say(f"the import of plugin {plugin} cannot be stopped; leave it out: {WITHOUT_VARIABLE}={plugin}")
            os._exit(1)
        signal.setitimer(signal.ITIMER_REAL, 1.0)  # lest it catch this and go on
        raise TookTooLong(f"more than {allowed.spent}, which {LIMIT_VARIABLE} changes")

    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, allowed.processor_s)
    try:
        yield
    except TookTooLong:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        say(
            f"plugin {plugin} is not imported in {allowed.spent}; spare the wait: {WITHOUT_VARIABLE}={plugin}"
        )
        raise
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def processor_limit_s() -> float:
    """What an import may take [s].

    Raises
    ------
    UserError
        When `LIMIT_VARIABLE` is no number above 0.
    """
    text = os.environ.get(LIMIT_VARIABLE, str(IMPORT_S))
    try:
        limit_s = float(text)
    except ValueError:
        limit_s = math.nan
    if not 0 < limit_s < _LONGEST_S:
        expected = "seconds of processor time above 0, as in TACOS_IMPORT_S=120"
        raise UserError(Fault(LIMIT_VARIABLE, f"it is {text!r}", expected))
    return limit_s


class _Allowance:
    """The time an import has, from now on.

    Processor time of the thread that imports is what counts. Where it waits, for a disk, a lock, or other
    programs that keep the processor busy, the clock is given `CLOCK_PER_PROCESSOR_S` times as long.

    Parameters
    ----------
    processor_s
        The most processor time [s].
    """

    def __init__(self, processor_s: float) -> None:
        self.processor_s = processor_s
        self.clock_s = processor_s * CLOCK_PER_PROCESSOR_S
        self._processor_began_s, self._clock_began_s = time.thread_time(), time.monotonic()

    def left_s(self) -> float:
        """In how many seconds it can be used up at the earliest; 0 once it is [s]."""
        processor_s, clock_s = self._left_s()
        return max(min(processor_s, clock_s), _SHORTEST_S) if processor_s > 0 < clock_s else 0.0

    @property
    def spent(self) -> str:
        """What was used up, in words."""
        if self._left_s()[0] <= 0:
            return f"{self.processor_s:g} s of processor time"
        return f"{self.clock_s:g} s by the clock"

    def _left_s(self) -> tuple[float, float]:
        processor_s = time.thread_time() - self._processor_began_s
        clock_s = time.monotonic() - self._clock_began_s
        return self.processor_s - processor_s, self.clock_s - clock_s
