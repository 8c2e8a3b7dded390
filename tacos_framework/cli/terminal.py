"""Text for the terminal, without the control characters that files may hold.

A name in a recipe, a catalog or a folder may hold escape sequences that move the cursor, recolour what was
said before, or set the title of the window; marks of direction show text in another order than it has.
"""

from __future__ import annotations

import logging
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any, TextIO

from tacos_framework.errors import printable


class PrintableStream:
    """A stream whose text is made `tacos_framework.errors.printable`; all else is that of the stream."""

    def __init__(self, stream: TextIO):
        self.stream = stream

    def write(self, text: str) -> int:
        """Write text without control characters; gives the length of what was handed in."""
        self.stream.write(printable(text))
        return len(text)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.stream, name)


@contextmanager
def printable_output() -> Iterator[None]:
    """Strips control characters from all output within."""
    streams: tuple[Any, Any] = sys.stdout, sys.stderr
    sys.stdout, sys.stderr = map(PrintableStream, streams)
    try:
        yield
    finally:
        sys.stdout, sys.stderr = streams


def terminal_errors() -> TextIO:
    """Standard error for a bar, which moves the cursor: what it shows must be printable by itself."""
    return sys.stderr.stream if isinstance(sys.stderr, PrintableStream) else sys.stderr


@contextmanager
def log_on_terminal(packages: Iterable[str]) -> Iterator[None]:
    """Copies the log of these packages to standard error within."""
    from tacos_framework.store.log import heard_by

    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(logging.Formatter("%(message)s"))
    with heard_by(handler, packages):
        yield
