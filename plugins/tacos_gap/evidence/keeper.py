"""The code inside a process that keeps evidence; see `tacos_gap.evidence.elsewhere`."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Any

from tacos_framework import in_one_thread
from tacos_gap.evidence.contract import Label, PictureEvidence
from tacos_plugins.executors.worker import WorkerState


@dataclass(frozen=True)
class Job:
    """A function to apply to each of some things.

    - `things`: each the number of evidence that is kept, or whatever else travels.
    - `forgotten`: numbers of evidence that nobody will ask for again.
    """

    function: Callable[[Any], Any]
    things: Sequence[Any]
    forgotten: Sequence[int] = ()


@dataclass(frozen=True)
class Kept:
    """Stands for evidence that stays in its process."""

    number: int
    labels: Sequence[Label] | None  # None where they are those of the evidence it was made of


class Keeper:
    """Applies functions to evidence that stays here.

    `needed`: what jobs will be about, so that it shows at once whether that can be loaded here.
    """

    def __init__(self, needed: Sequence[Any]) -> None:
        self._needed = needed
        self._known: dict[int, PictureEvidence] = {}
        self._last = 0

    @in_one_thread
    def __call__(self, job: Job) -> list[Any]:
        for number in job.forgotten:
            del self._known[number]
        return [self._applied(job.function, each) for each in job.things]

    def _applied(self, function: Callable[[Any], Any], thing: Any) -> Any:
        """What a function makes of a thing; evidence it returns is kept, under a number."""
        is_known = isinstance(thing, int)
        given = self._known[thing] if is_known else thing
        made = function(given)
        if not isinstance(made, PictureEvidence):
            return made
        if made is given:
            return Kept(thing, None)
        self._last += 1
        self._known[self._last] = made
        return Kept(self._last, None if is_known else made.labels)


def serve(channel: Connection) -> None:
    """Answer jobs until the channel is closed, as it is when the parent ends; first comes the `Keeper`."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches every process; the parent decides
    import cv2

    cv2.setNumThreads(1)
    try:
        state = WorkerState(channel.recv_bytes())
        while True:
            channel.send_bytes(state.answer(channel.recv_bytes()))
    except (EOFError, ConnectionResetError, BrokenPipeError):
        os._exit(0)
