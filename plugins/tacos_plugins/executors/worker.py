"""What runs inside a worker process of `ProcessExecutor`. Imports little, so that workers start fast."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable
from functools import cache
from multiprocessing.connection import Connection
from multiprocessing.reduction import ForkingPickler
from typing import Any

_payload = b""
"""The pickled function of this worker's pool, set once when the process starts."""


def start(payload: bytes, lifeline: Connection, threads: int) -> None:
    """Prepare a new worker.

    Parameters
    ----------
    payload
        The pickled function this worker will evaluate, from the parent process.
    lifeline
        Reading end of a pipe of which the parent holds the other end: it breaks when the parent closes its
        pool, or dies in whatever way.
    threads
        Threads OpenCV may use here.
    """
    global _payload
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches every process; the parent decides
    threading.Thread(target=_die_with, args=(lifeline,), daemon=True).start()
    import cv2

    cv2.setNumThreads(threads)
    _payload = payload


def evaluate(job: Any) -> Any:
    """Evaluate one job. Unpickling happens here, so that its errors reach the caller like any other."""
    return _function()(job)


@cache
def _function() -> Callable[[Any], Any]:
    function: Callable[[Any], Any] = ForkingPickler.loads(_payload)
    return function


def _die_with(lifeline: Connection) -> None:
    lifeline.poll(None)  # nothing is ever written: it returns when the other end is closed
    os._exit(0)
