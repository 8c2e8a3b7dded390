"""Bytes of files that others made, by the one door for them, `tacos_framework.files`."""

from __future__ import annotations

from pathlib import Path

from tacos_framework.files import read_bytes


class Unreadable(ValueError):
    """A file cannot be read; the message says which and why."""


def file_bytes(file: Path) -> bytes:
    """All bytes of a regular file. Raises UserError where it cannot be read or is too large."""
    return read_bytes(file, "mesh_mb")
