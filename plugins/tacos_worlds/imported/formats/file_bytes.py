"""Bytes of files that others made: regular files only, of a size that fits, inside the model's folder."""

from __future__ import annotations

import os
import stat
from pathlib import Path

MOST_BYTES = 4 * 2**30
"""Larger files are refused [bytes]."""


class Unreadable(ValueError):
    """A file cannot be read; the message says which and why."""


def file_bytes(file: Path, most_bytes: int = MOST_BYTES) -> bytes:
    """All bytes of a regular file.

    Raises
    ------
    Unreadable
        Where it does not exist, is no regular file, may not be read, or is larger than `most_bytes`.
    """
    try:
        # Without O_NONBLOCK a named pipe would hang here for ever.
        descriptor = os.open(file, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    except OSError as error:
        raise Unreadable(f"{file.name} cannot be opened: {error.strerror}") from error
    with os.fdopen(descriptor, "rb") as stream:
        status = os.fstat(stream.fileno())
        if not stat.S_ISREG(status.st_mode):
            raise Unreadable(f"{file.name} is not a regular file")
        if status.st_size > most_bytes:
            raise Unreadable(f"{file.name} is {status.st_size} bytes long, more than {most_bytes}")
        return stream.read()


def neighbour(file: Path, name: str) -> Path:
    """A file that another one names, which has to lie in its folder or below.

    Raises
    ------
    Unreadable
        Where it leads out of the folder.
    """
    folder = file.parent.resolve()
    target = (folder / name).resolve()
    if not target.is_relative_to(folder):
        raise Unreadable(f"it refers to {name!r}, outside of its folder: copy that file beside it")
    return target
