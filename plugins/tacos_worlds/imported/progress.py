"""Log while a large file is made ready to be walked in."""

from __future__ import annotations

import logging
import time
from datetime import timedelta
from pathlib import Path

log = logging.getLogger(__name__)

LARGE = 200_000
"""Triangles from which on every stage is told, as each may take seconds."""

SHARES = {"geometry and floor": 0.27, "light": 0.73}
"""Of the time after reading: a room of 835,584 triangles with colours took 13.4 s of processor time."""


class Telling:
    """Names the file, its triangles, and how long the stages to come may take at the pace of those past."""

    def __init__(self, file: Path) -> None:
        self._name = file.name
        self._triangles = 0
        self._done = 0.0
        log.info("%s: reading %.3g MB", self._name, file.stat().st_size / 1e6)
        self._began_s = time.monotonic()

    def read(self, triangles: int) -> None:
        self._triangles = triangles
        if triangles >= LARGE:
            seconds = time.monotonic() - self._began_s
            log.info("%s: %s triangles, read in %.0f s", self._name, f"{triangles:,}", seconds)
        self._began_s = time.monotonic()

    def done(self, stage: str) -> None:
        self._done += SHARES[stage]
        if self._triangles < LARGE:
            return
        past_s = time.monotonic() - self._began_s
        left = timedelta(seconds=round(past_s / self._done * (1 - self._done)))
        rest = f"about {left} left" if self._done < 0.999 else f"ready after {past_s:.0f} s"
        log.info("%s, %s triangles: %s done, %s", self._name, f"{self._triangles:,}", stage, rest)
