"""The log of worker processes, said by the process that started them.

Each worker has a pipe of its own: a queue that all share would stay locked by a worker that is killed while
it writes. A thread of the parent reads it, so that lines come while the parent is busy with other things, and
a worker never waits for long to say one.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping
from multiprocessing.connection import Connection
from threading import Thread
from typing import Any

DRAINED_S = 2.0
"""Time an ended worker's pipe may stay open [s], as when a process that the worker forked outlives it."""


def explicit_levels() -> dict[str, int]:
    """The levels that were set in this process, by the name of the logger; the root's name is empty."""
    loggers = logging.root.manager.loggerDict.items()
    named = {name: each.level for name, each in loggers if isinstance(each, logging.Logger) and each.level}
    return {"": logging.root.level, **named}


def send_logs(channel: Connection, levels: Mapping[str, int]) -> None:
    """Send all that this process logs from now on, and the warnings of Python with it.

    `levels`: the level of each logger, as in the process that reads them (`explicit_levels`).
    """
    for name, level in levels.items():
        logging.getLogger(name).setLevel(level)
    logging.root.handlers = [_ToParent(channel)]
    logging.captureWarnings(True)


class _ToParent(logging.Handler):
    """Sends records with their message formatted, tracebacks included, and without what may not travel."""

    def __init__(self, channel: Connection) -> None:
        super().__init__()
        self._channel = channel

    def emit(self, record: logging.LogRecord) -> None:
        message = self.format(record)
        travels = {key: value for key, value in vars(record).items() if isinstance(value, str | int | float)}
        plain = {**travels, "msg": message, "exc_text": None, "stack_info": None}  # the message has both
        try:
            self._channel.send(plain)
        except (BrokenPipeError, ConnectionResetError):
            logging.root.handlers = []  # the parent is gone, and this process ends with it


class WorkerLog:
    """Says here what one worker logs there, until that worker ends.

    - `worker`: what the worker is called in front of each of its messages.
    """

    def __init__(self, channel: Connection, worker: str) -> None:
        self._channel, self._worker = channel, worker
        self._thread = Thread(target=self._read, name=f"log of {worker}", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Say what a worker that has ended still left in its pipe."""
        self._thread.join(DRAINED_S)

    def _read(self) -> None:
        with self._channel:
            while True:
                try:
                    plain: dict[str, Any] = self._channel.recv()
                except (EOFError, OSError):  # OSError: killed in the middle of a record
                    return
                record = logging.makeLogRecord({**plain, "msg": f"{self._worker}: {plain['msg']}"})
                logger = logging.getLogger(record.name)
                if logger.isEnabledFor(record.levelno):
                    logger.handle(record)
