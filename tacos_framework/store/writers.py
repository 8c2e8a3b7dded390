"""Writing files so that whoever dies while it does leaves the old file or the new one, never half of it."""

from __future__ import annotations

import errno
import os
from pathlib import Path

PARTIAL = ".partial"
"""Ends the names of files that are being written; what is left of them after a crash counts for nothing."""


def replace_file(path: Path, data: bytes) -> None:
    """Write a file whole or not at all, and out to the disk; its folder is made where it is missing."""
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(path.name + PARTIAL)
    try:
        with partial.open("wb") as file:
            file.write(data)
            to_disk(file.fileno())
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)  # a full disk needs the room
    folder = os.open(path.parent, os.O_RDONLY | os.O_DIRECTORY)
    try:
        to_disk(folder)
    finally:
        os.close(folder)


def to_disk(descriptor: int) -> None:
    """Have the system write out what it holds back, so that it outlives the machine's power."""
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno != errno.EINVAL:  # file systems that cannot, for folders
            raise
