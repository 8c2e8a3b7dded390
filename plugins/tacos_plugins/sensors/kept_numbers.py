"""Normal numbers of the frames drawn last, which are not drawn again when one is simulated many times."""

from __future__ import annotations

from threading import Lock

import numpy as np
from numpy.typing import NDArray

from tacos_plugins.sensors.gaussian import NormalNumbers

_AT_ONCE = 1 << 18
"""Samples drawn in one go, a multiple of 16."""


class KeptNumbers:
    """The same numbers as `NormalNumbers`, to the bit, remembered by frame. Threads may share it.

    Parameters
    ----------
    most_bytes
        What is remembered at most; the frames asked for last stay.
    """

    def __init__(self, most_bytes: int):
        self._most_bytes = most_bytes
        self._frames: dict[tuple[bytes, int], NDArray[np.float32]] = {}
        self._kept_bytes = 0
        self._lock = Lock()

    def of(self, rng: np.random.Generator, count: int) -> NumbersInTurn:
        """Those of a frame of so many samples, whose generator is `rng`."""
        fresh = NormalNumbers(rng)
        numbers = self._known(fresh.key, count)
        if numbers is None:
            numbers = _drawn(fresh, count)
            self._keep(fresh.key, numbers)
        return NumbersInTurn(numbers)

    def _known(self, key: bytes, count: int) -> NDArray[np.float32] | None:
        with self._lock:
            numbers = self._frames.pop((key, count), None)
            if numbers is not None:
                self._frames[key, count] = numbers  # the last now
            return numbers

    def _keep(self, key: bytes, numbers: NDArray[np.float32]) -> None:
        with self._lock:
            if (key, len(numbers)) not in self._frames:  # another thread may have drawn them, too
                self._frames[key, len(numbers)] = numbers
                self._kept_bytes += numbers.nbytes
            while self._kept_bytes > self._most_bytes:
                self._kept_bytes -= self._frames.pop(next(iter(self._frames))).nbytes


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
