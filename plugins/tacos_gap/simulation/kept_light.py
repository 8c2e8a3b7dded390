"""Light of one capture that is simulated again and again: what effects make of it is worked out once."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

Samples = NDArray[np.float32]
Key = tuple[str, ...]
"""The effects behind some samples, in the order they act."""


class KeptLight:
    """Samples by the effects that made them, the last ones used."""

    def __init__(self, most_bytes: int) -> None:
        self._most_bytes = most_bytes
        self._known: dict[Key, Samples | None] = {}
        self._bytes = 0

    def after(self, effects: Sequence[str], make: Callable[[], Samples | None]) -> Samples | None:
        """Samples after those effects, made where they are not known; None where chance is among them."""
        key = tuple(effects)
        if key in self._known:
            found = self._known[key] = self._known.pop(key)  # the last now
            return found
        made = self._known[key] = make()
        self._bytes += _bytes_of(made)
        while self._bytes > self._most_bytes:
            self._bytes -= _bytes_of(self._known.pop(next(iter(self._known))))
        return made


def _bytes_of(samples: Samples | None) -> int:
    return 0 if samples is None else samples.nbytes
