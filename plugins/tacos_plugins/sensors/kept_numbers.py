"""Normal numbers of a few frames that are simulated again and again: they are drawn once."""

from __future__ import annotations

from threading import Lock

import numpy as np
from numpy.typing import NDArray

from tacos_plugins.sensors.gaussian import NormalNumbers

_AT_ONCE = 1 << 18
"""Samples drawn in one go, a multiple of 16."""

_SAMPLE_BYTES = np.dtype(np.float32).itemsize


class KeptNumbers:
    """The same numbers as `NormalNumbers`, to the bit, remembered by frame. Threads may share it.

    - `most_bytes`: what is remembered at most; frames for which there is no room are drawn each time.
    """

    def __init__(self, most_bytes: int):
        self._room_bytes = most_bytes
        self._frames: dict[tuple[bytes, int], NDArray[np.float32]] = {}
        self._lock = Lock()

    def of(self, rng: np.random.Generator, count: int) -> NormalNumbers | NumbersInTurn:
        """Those of a frame of so many samples, whose generator is `rng`."""
        fresh = NormalNumbers(rng)
        with self._lock:
            if (numbers := self._frames.get((fresh.key, count))) is not None:
                return NumbersInTurn(numbers)
            if count * _SAMPLE_BYTES > self._room_bytes:
                return fresh
            self._room_bytes -= count * _SAMPLE_BYTES
            numbers = self._frames[fresh.key, count] = _drawn(fresh, count)
            return NumbersInTurn(numbers)


class NumbersInTurn:
    """Numbers that are there, handed out as `NormalNumbers` hands out its own."""

    def __init__(self, numbers: NDArray[np.float32]):
        self._numbers = numbers
        self._place = 0

    def fill(self, out: NDArray[np.float32]) -> None:
        """Fill (N,) float32 with the next N numbers."""
        out[:] = self._numbers[self._place : self._place + len(out)]
        self._place += len(out)


def _drawn(numbers: NormalNumbers, count: int) -> NDArray[np.float32]:
    """(N,) the first numbers of a frame."""
    drawn = np.empty(count, np.float32)
    for start in range(0, count, _AT_ONCE):
        numbers.fill(drawn[start : start + _AT_ONCE])
    return drawn
