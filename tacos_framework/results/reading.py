"""Reading the files of a run: as it left them, or a sentence on what is wrong with them."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from tacos_framework.errors import Fault, UserError
from tacos_framework.files import limits
from tacos_framework.files.limits import MB
from tacos_framework.files.regular import NotAFile, open_regular
from tacos_framework.results.checksums import (
    Damaged,
    Lines,
    checked_json,
    checked_lines,
    checked_text,
    checksum,
    json_object,
)

Content = TypeVar("Content")

RESULT = "result.json"
"""The file that says what came out of a run."""

DESIGNED = "designed"
"""What the results of a study call the camera that was designed, among the products."""

MANIFEST = "manifest.json"
"""The file that says what a run was started with; runs of versions that wrote no checksums have none."""


_LIMITS = {
    "checkpoint.json": "lines_mb",  # grows with the study, as logs do
    ".json": "json_mb",
    ".jsonl": "lines_mb",
    ".yaml": "text_mb",
    ".safetensors": "weights_mb",
    ".png": "image_mb",
}
"""The one of `tacos_framework.files.limits.Limits` for a file's size, by its name or how that ends."""


def file_of_run(path: Path) -> bytes:
    """The bytes of a file of a run.

    Raises
    ------
    Damaged
        When it is not there, is no regular file, cannot be read or is too large.
    """
    limit = _LIMITS.get(path.name, _LIMITS.get(path.suffix, "text_mb"))
    most = limits().bytes_of(limit)
    try:
        with open_regular(path) as file:
            size_bytes = os.fstat(file.fileno()).st_size
            if size_bytes > most:
                remedy = limits().remedy(limit, size_bytes / MB)
                raise Damaged(f"it has {size_bytes} bytes, where {most} are read. {remedy}")
            return file.read(most)
    except NotAFile as error:
        raise Damaged(f"it is {error.strerror}") from error
    except OSError as error:
        raise Damaged(f"it cannot be read: {error.strerror or error}") from error


def checked_file(path: Path, parse: Callable[[bytes], Content]) -> Content:
    """What a file of a run holds.

    Raises
    ------
    UserError
        When it is damaged.
    """
    try:
        return parse(file_of_run(path))
    except Damaged as error:
        raise UserError(damage(path, str(error))) from error


def damage(path: Path, what: str) -> Fault:
    """The fault of a file that is not as the run left it."""
    return Fault(
        str(path),
        f"the file is damaged: {what}",
        "the file as the run left it",
        f"Restore it from a copy, or start a new run; `tacos verify {path.parent}` looks at all files.",
    )


def read_run_json(path: Path) -> dict[str, Any]:
    """``result.json`` or another JSON file of a run, of earlier versions as well.

    Raises
    ------
    UserError
        When it cannot be read, or is not as the run left it.
    """
    return _read_run_file(path, b'\n "checksum": "', checked_json, json_object)


def read_result(folder: Path) -> dict[str, Any]:
    """What came out of a run, ``result.json``, of earlier versions as well.

    Raises
    ------
    UserError
        When the folder has none, it cannot be read, or is not as the run left it.
    """
    path = folder / RESULT
    if not path.exists():
        remedy = "Name the folder that tacos-run wrote with --out; a run that has not ended has none yet."
        raise UserError(Fault(str(folder), f"there is no {RESULT} here", "the results of a run", remedy))
    return read_run_json(path)


def read_run_lines(path: Path) -> Lines:
    """A file of JSON lines of a run, of earlier versions as well; empty where there is none.

    Raises
    ------
    UserError
        When it cannot be read, or is not as the run left it.
    """
    return (
        _read_run_file(path, b'"checksum": "', checked_lines, _unchecked_lines) if path.exists() else Lines()
    )


def read_run_text(path: Path) -> str:
    """``recipe.yaml`` of a run, of earlier versions as well.

    Raises
    ------
    UserError
        When it cannot be read, or is not as the run left it.
    """
    return _read_run_file(path, b"# checksum: ", checked_text, lambda data: data.decode(errors="replace"))


def _read_run_file(
    path: Path, mark: bytes, checked: Callable[[bytes], Content], unchecked: Callable[[bytes], Content]
) -> Content:
    """What a file holds; only a run of before there were manifests may lack the mark of a checksum."""
    earlier = not (path.parent / MANIFEST).exists()

    def parse(data: bytes) -> Content:
        return unchecked(data) if earlier and mark not in data else checked(data)

    return checked_file(path, parse)


def read_recorded(path: Path, recorded: str) -> bytes:
    """A file whose checksum stands elsewhere.

    Raises
    ------
    UserError
        When it cannot be read, or is not as the run left it.
    """

    def parse(data: bytes) -> bytes:
        if checksum(data) != recorded:
            raise Damaged("its checksum is not the one that the run wrote down")
        return data

    return checked_file(path, parse)


def _unchecked_lines(data: bytes) -> Lines:
    """Lines of an earlier version, of which the last may be cut short."""
    values: list[dict[str, Any]] = []
    pieces = data.split(b"\n")
    for number, line in enumerate(pieces, 1):
        try:
            values += [json_object(line)] if line else []
        except Damaged as error:
            if number == len(pieces):
                return Lines(tuple(values), torn=len(line))
            raise Damaged(f"line {number}: {error}") from error
    return Lines(tuple(values))
