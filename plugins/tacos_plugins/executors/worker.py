"""The code inside a worker process of `ProcessExecutor`. Imports little, so that workers start fast."""

from __future__ import annotations

import os
import pickle
import signal
import threading
import traceback
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from multiprocessing import parent_process
from multiprocessing.connection import Connection
from multiprocessing.reduction import ForkingPickler
from typing import Any

from tacos_plugins.executors.worker_logs import send_logs

LEAVE = b""
"""Sent instead of a job to a worker that is to end."""


@dataclass(frozen=True)
class Answer:
    """Message of a worker for a finished job; and once, empty, when it is ready for the first."""

    value: Any = None
    error: Exception | None = None
    traceback: str = ""
    """Traceback, as text."""
    resident_mib: float = 0.0
    """Memory the worker holds after the job [MiB]."""


class WorkerState:
    """A function that is unpickled with its first job, and kept for all further ones."""

    def __init__(self, payload: bytes) -> None:
        self._payload = payload
        self._function: Callable[[Any], Any] | None = None

    def answer(self, message: bytes) -> bytes:
        """The pickled `Answer` to a pickled job."""
        try:
            if self._function is None:  # unpickled here, so that its errors reach the caller like any other
                self._function = ForkingPickler.loads(self._payload)
            answer = Answer(self._function(ForkingPickler.loads(message)), resident_mib=resident_mib())
        except Exception as error:  # noqa: BLE001 - whatever it is, the caller gets it
            answer = Answer(error=error, traceback=traceback.format_exc(), resident_mib=resident_mib())
        return _packed(answer)


def serve(
    payload: bytes, channel: Connection, threads: int, logs: Connection, levels: Mapping[str, int]
) -> None:
    """Evaluate jobs until told to leave.

    - `payload`: the pickled function this worker evaluates, from the parent process.
    - `channel`: brings pickled jobs, takes pickled answers.
    - `threads`: threads OpenCV may use here.
    - `logs`: takes what is logged here.
    - `levels`: the levels of loggers in the parent process.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches every process; the parent decides
    threading.Thread(target=_die_with_parent, daemon=True).start()
    send_logs(logs, levels)
    import cv2

    cv2.setNumThreads(threads)
    channel.send_bytes(_packed(Answer()))
    state = WorkerState(payload)
    while (message := channel.recv_bytes()) != LEAVE:
        channel.send_bytes(state.answer(message))
    os._exit(0)  # drivers may hang while a GL context is torn down; the system takes everything back


def _packed(answer: Answer) -> bytes:
    """The pickled answer; an error about it where it cannot travel."""
    try:
        packed = bytes(ForkingPickler.dumps(answer))
        if answer.error is not None:
            ForkingPickler.loads(packed)  # an exception may pickle and yet not come back
        return packed
    except (pickle.PicklingError, TypeError, AttributeError, ValueError) as reason:
        what = repr(answer.error) if answer.error is not None else f"a {type(answer.value).__name__}"
        error = RuntimeError(f"{what} cannot travel between processes: {reason}")
        return bytes(
            ForkingPickler.dumps(
                Answer(error=error, traceback=answer.traceback, resident_mib=answer.resident_mib)
            )
        )


def resident_mib() -> float:
    """Memory this process holds [MiB]; 0 where the system does not tell."""
    try:
        with open("/proc/self/statm", encoding="ascii") as file:
            pages = int(file.read().split()[1])
    except OSError:
        return 0.0
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20


def _die_with_parent() -> None:
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(0)
