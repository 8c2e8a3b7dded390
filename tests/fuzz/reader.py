"""A way to read one kind of file, and what it makes of one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from tacos_framework.errors import UserError


@dataclass(frozen=True)
class Reader:
    """A way to read one kind of file.

    Parameters
    ----------
    suffix
        How the file's name ends.
    read
        Reads it, as far as its users do.
    example
        Makes a small whole file.
    structure
        What `tests.fuzz.mutations.damaged` knows of its inside; empty for bytes alone.
    whole_or_fault
        Whether every file that lacks its end must be refused.
    share
        Which part of the inputs it is given: less for those that take long [1].
    """

    suffix: str
    read: Callable[[Path], object]
    example: Callable[[], bytes]
    structure: Literal["", "json", "glb"] = ""
    whole_or_fault: bool = False
    share: float = 1.0


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
