"""Reading the files of a run: as it left them, or a sentence on what is wrong with them."""

from __future__ import annotations

import json
import logging
import os
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from tacos_framework.errors import Fault, UserError
from tacos_framework.files import limits
from tacos_framework.files.limits import MB
from tacos_framework.files.regular import NotAFile, open_regular
from tacos_framework.files.trees import new_checksum
from tacos_framework.store.database import DATABASE, Database, damage

log = logging.getLogger(__name__)

Content = TypeVar("Content")

RESULT = "result.json"
"""The file that says what came out of a run."""

DESIGNED = "designed"
"""Name of the designed camera in the results of a study."""

FILES = "files"
"""Kind of entries of the database: digests of the files beside it, by their names."""

_LIMITS = {
    ".json": "json_mb",
    ".jsonl": "lines_mb",
    ".yaml": "text_mb",
    ".safetensors": "weights_mb",
    ".png": "image_mb",
}
"""The one of `tacos_framework.files.limits.Limits` for a file's size, by how its name ends."""


class DamagedError(ValueError):
    """A file is not as the run left it; the message says what is wrong, in a few words."""


def digest(data: bytes) -> str:
    """Digest of a file, as the database keeps it."""
    return new_checksum(data).hexdigest()


def file_of_run(path: Path, recorded: str | None = None) -> bytes:
    """The bytes of a file of a run.

    Raises `DamagedError` when it is not there, is no regular file, cannot be read, is too large, or has not
    the digest that was recorded.
    """
    limit = _LIMITS.get(path.suffix, "text_mb")
    most = limits().bytes_of(limit)
    try:
        with open_regular(path) as file:
            size_bytes = os.fstat(file.fileno()).st_size
            if size_bytes > most:
                remedy = limits().remedy(limit, size_bytes / MB)
                raise DamagedError(f"it has {size_bytes} bytes, where {most} are read. {remedy}")
            data = file.read(most)
    except NotAFile as error:
        raise DamagedError(f"it is {error.strerror}") from error
    except OSError as error:
        raise DamagedError(f"it cannot be read: {error.strerror or error}") from error
    if recorded is not None and digest(data) != recorded:
        raise DamagedError("its digest is not the one that the run wrote down")
    return data


def read_run_file(path: Path, parse: Callable[[bytes], Content], recorded: str | None = None) -> Content:
    """The content of a run's file, checked against its digest.

    `parse`: turns its bytes into what they mean; raises DamagedError where they do not. `recorded`: the
    digest that it must have; that in the database of its folder, if there is one, when left out.

    Raises `UserError` when it is damaged.
    """
    if recorded is None and (path.parent / DATABASE).exists():
        with Database(path.parent / DATABASE, read_only=True) as database:
            recorded = database.get(FILES, path.name)
    try:
        return parse(file_of_run(path, recorded))
    except DamagedError as error:
        raise UserError(damage(path, str(error))) from error


def json_object(data: bytes) -> dict[str, Any]:
    """The mapping in a JSON object.

    Raises `DamagedError` when it is none.
    """
    try:
        value = json.loads(data)
    except (ValueError, RecursionError) as error:
        raise DamagedError(f"it is no JSON: {error}") from error
    if not isinstance(value, dict):
        raise DamagedError("it is no JSON object")
    value.pop("checksum", None)  # versions without a database kept it there
    return value


def read_run_json(path: Path) -> dict[str, Any]:
    """``result.json`` or another JSON file of a run, of earlier versions as well.

    Raises `UserError` when it cannot be read, or is not as the run left it.
    """
    return read_run_file(path, json_object)


def read_result(folder: Path) -> dict[str, Any]:
    """The ``result.json`` of a run, of earlier versions as well.

    Raises `UserError` when the folder has none, it cannot be read, or is not as the run left it.
    """
    path = folder / RESULT
    if not path.exists():
        remedy = "Name the folder that tacos-run wrote with --out; a run that has not ended has none yet."
        raise UserError(Fault(str(folder), f"there is no {RESULT} here", "the results of a run", remedy))
    return read_run_json(path)


def read_run_lines(path: Path) -> list[dict[str, Any]]:
    """The lines that a run wrote to a file of JSON lines, of earlier versions as well.

    They come from the database of its folder, if there is one. A last line that was cut short is left out.

    Raises `UserError` when they cannot be read, or are not as the run left them.
    """
    if (path.parent / DATABASE).exists():
        with Database(path.parent / DATABASE, read_only=True) as database:
            return list(database.all(path.name).values())
    return read_run_file(path, partial(_json_lines, path.name)) if path.exists() else []


def _json_lines(name: str, data: bytes) -> list[dict[str, Any]]:
    values: list[dict[str, Any]] = []
    pieces = data.split(b"\n")
    for number, line in enumerate(pieces, 1):
        try:
            values += [json_object(line)] if line else []
        except DamagedError as error:
            if number == len(pieces):
                log.warning("%s: the last line was cut short and is left out", name)
                break
            raise DamagedError(f"line {number}: {error}") from error
    return values
