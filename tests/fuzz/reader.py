"""A way to read one kind of file, and what it makes of one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from tacos_framework.errors import UserError


@dataclass(frozen=True)
class Reader:
    """A way to read one kind of file."""

    suffix: str
    """How the file's name ends."""
    read: Callable[[Path], object]
    """Reads it, as far as its users do."""
    example: Callable[[], bytes]
    """Makes a small whole file."""
    structure: Literal["", "json", "glb"] = ""
    """What `tests.fuzz.mutations.damaged` knows of its inside; empty for bytes alone."""
    whole_or_fault: bool = False
    """Whether every file that lacks its end must be refused."""
    share: float = 1.0
    """Which part of the inputs it is given: less for those that take long [1]."""


def read_or_refuse(reader: Reader, content: bytes, folder: Path) -> object | UserError:
    """What a file of this content gives; any exception but `UserError` is a defect and passes."""
    path = folder / f"file{reader.suffix}"
    path.write_bytes(content)
    try:
        return reader.read(path)
    except UserError as error:
        if not error.faults:
            raise ValueError("a UserError without any fault") from error
        return error
