"""Renderers in processes of their own that draw a frame when asked and say what it cost them.

Each has its own OpenGL context and, where told so, its own tree of sources. As they take turns frame by
frame, whatever else the machine does weighs on all alike; only processor time is reported.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Sequence
from contextlib import suppress
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from renderers import Picture, make
from renderers.tour import Tour

WARM_UP_FRAMES = 4
"""Frames drawn first, which compile shaders and upload what each part of the way needs."""


class RendererProcess:
    """One renderer with a tour, in a process of its own.

    Parameters
    ----------
    name
        One of `renderers.NAMES`.
    tour
        What it is to draw.
    tree
        Checkout of this repository whose packages it imports; None for those of this process.
    """

    def __init__(self, name: str, tour: Tour, tree: Path | None = None) -> None:
        self._name = name
        self._connection, theirs = Pipe()
        environment = dict(os.environ)
        if tree is not None:
            environment["PYTHONPATH"] = f"{tree.resolve()}{os.pathsep}{tree.resolve() / 'plugins'}"
        command = [sys.executable, __file__, str(theirs.fileno()), name]
        self._process = subprocess.Popen(command, env=environment, pass_fds=[theirs.fileno()])
        theirs.close()
        self._connection.send(tour)

    def draw(self, frame: int, ids: bool = True) -> float:
        """Draw a frame and return the processor time of the whole process [s]."""
        cpu_s, _ = self._ask(frame, ids, False)
        return cpu_s

    def picture(self, frame: int, ids: bool = True) -> Picture:
        """Draw a frame and hand it over."""
        _, picture = self._ask(frame, ids, True)
        assert picture is not None
        return picture

    def close(self) -> None:
        """End the process."""
        self._connection.send(None)
        self._process.wait()

    def _ask(self, *request: object) -> tuple[float, Picture | None]:
        try:
            self._connection.send(request)
            answer: tuple[float, Picture | None] = self._connection.recv()
        except (EOFError, ConnectionError):
            raise SystemExit(f"{self._name} ended with code {self._process.wait()}; see above") from None
        return answer


def cpu_times(
    processes: Sequence[RendererProcess], with_ids: Sequence[bool], frames: int, rounds: int
) -> NDArray[np.float64]:
    """(processes, frames) least processor time of several rounds, all in turns [s]."""
    turns = list(zip(processes, with_ids, strict=True))
    for frame in np.linspace(0, frames - 1, WARM_UP_FRAMES).astype(int):
        for process, ids in turns:
            process.draw(int(frame), ids)
    cpu_s = np.empty((rounds, len(turns), frames))
    for each in range(rounds):
        for frame in range(frames):
            for place in np.roll(np.arange(len(turns)), frame):  # no one always follows the same other
                process, ids = turns[place]
                cpu_s[each, place, frame] = process.draw(frame, ids)
    least: NDArray[np.float64] = cpu_s.min(axis=0)
    return least


def _serve(connection: Connection, name: str) -> None:
    renderer = make(name, connection.recv())
    for frame, ids, hand_over in iter(connection.recv, None):
        start = time.process_time()
        drawn = renderer.draw(frame, ids)
        cpu_s = time.process_time() - start
        connection.send((cpu_s, renderer.picture(drawn) if hand_over else None))


if __name__ == "__main__":
    with suppress(EOFError):  # whoever asked is gone
        _serve(Connection(int(sys.argv[1])), sys.argv[2])
