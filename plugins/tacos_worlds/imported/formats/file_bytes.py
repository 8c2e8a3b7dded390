"""Bytes of files that others made, by the one door for them, `tacos_framework.files`."""

from __future__ import annotations

from pathlib import Path

from tacos_framework.files import read_bytes


class Unreadable(ValueError):
    """A file cannot be read; the message says which and why."""


def file_bytes(file: Path, within: Path | None = None) -> bytes:
    """All bytes of a regular file, which has to lie in the folder `within` where that is given.

    Raises
    ------
    UserError
        Where it cannot be read, is too large, or lies elsewhere.
    """
    return read_bytes(file, "mesh_mb", within=within)


def neighbour(file: Path, name: str) -> bytes:
    """All bytes of a file that another one names, which has to lie in its folder or below."""
    return file_bytes(file.parent / name, within=file.parent)
