"""The log of a run: who hears it, and the file it is kept in."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def heard_by(handler: logging.Handler, packages: Iterable[str]) -> Iterator[None]:
    """Hand a handler what these packages note in their log meanwhile, from the level INFO on."""
    loggers = [logging.getLogger(name) for name in sorted(set(packages))]
    before = [logger.level for logger in loggers]
    for logger in loggers:
        logger.addHandler(handler)
        logger.setLevel(logging.INFO)
    try:
        yield
    finally:
        for logger, level in zip(loggers, before, strict=True):
            logger.removeHandler(handler)
            logger.setLevel(level)


@contextmanager
def logging_to(file: LogFile, packages: Iterable[str]) -> Iterator[None]:
    """Write the log of these packages to a file meanwhile, and close it.

    Where nobody listens to the root logger, warnings still come on standard error: Python itself prints them
    only until a logger has a handler.
    """
    root = logging.getLogger()
    stands_in = None if root.handlers else logging.lastResort
    if stands_in is not None:
        root.addHandler(stands_in)
    try:
        with heard_by(file, packages):
            yield
    finally:
        file.close()
        if stands_in is not None:
            root.removeHandler(stands_in)


class LogFile(logging.FileHandler):
    """A log that goes quiet where it cannot be written; the run says what is wrong, and the log need not.

    Raises `OSError` when it cannot be opened.

    - `path`: the file, to which is appended.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(path, encoding="utf-8")
        self.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(name)s: %(message)s"))

    def handleError(self, record: logging.LogRecord) -> None:
        """Drop the line."""
