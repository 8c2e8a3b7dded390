"""Checksums inside the files of a run, so that what was damaged is found out before it is believed.

A JSON file ends with its own checksum, a YAML file with one in a comment, and each line of a file of JSON
lines with one that also covers the line before: none can be changed, lost or moved without the next one
telling.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from tacos_framework.files.trees import new_checksum

_HEX = rb"([0-9a-f]{32})"
_JSON = re.compile(rb'(\{.*),\n "checksum": "' + _HEX + rb'"\n\}\n', re.DOTALL)
_LINE = re.compile(rb'(\{.*), "checksum": "' + _HEX + rb'"\}')
_TEXT = re.compile(rb"(.*)# checksum: " + _HEX + rb"\n", re.DOTALL)


class Damaged(ValueError):
    """A file is not as the run left it; the message says what is wrong, in a few words."""


def checksum(data: bytes, after: str = "") -> str:
    """The checksum of data that follow on something with a checksum of its own."""
    return new_checksum(after.encode() + data).hexdigest()


def json_with_checksum(value: Mapping[str, Any]) -> bytes:
    """Plain data as a JSON file; NaN is refused (ValueError)."""
    body = json.dumps(value, indent=1, allow_nan=False, ensure_ascii=False).encode()[:-2]
    return body + b',\n "checksum": "' + checksum(body).encode() + b'"\n}\n'


def checked_json(data: bytes) -> dict[str, Any]:
    """The content of a JSON file, without its checksum.

    Raises
    ------
    Damaged
        When it is not as it was written.
    """
    return json_object(_body(_JSON, data) + b"\n}")


def text_with_checksum(text: str) -> str:
    """A text in which ``#`` begins a comment, with its checksum as the last line."""
    return f"{text}# checksum: {checksum(text.encode())}\n"


def checked_text(data: bytes) -> str:
    """A text without its checksum.

    Raises
    ------
    Damaged
        When it is not as it was written.
    """
    try:
        return _body(_TEXT, data).decode()
    except UnicodeDecodeError as error:
        raise Damaged(f"it is no text: {error}") from error


def _body(form: re.Pattern[bytes], data: bytes) -> bytes:
    """What stands before the checksum at the end of a file, which must be that of it."""
    found = form.fullmatch(data)
    if found is None:
        raise Damaged("it does not end with its checksum")
    if checksum(found[1]) != found[2].decode():
        raise Damaged("its checksum does not fit its content")
    return found[1]


def line_with_checksum(value: Mapping[str, Any], after: str = "") -> tuple[bytes, str]:
    """Plain data as a line of JSON, and its checksum; `after` is that of the line before."""
    body = json.dumps(value, allow_nan=False, ensure_ascii=False).encode()[:-1]
    found = checksum(body, after)
    return body + b', "checksum": "' + found.encode() + b'"}\n', found


def lines_with_checksums(values: Iterable[Mapping[str, Any]]) -> bytes:
    """A whole file of JSON lines."""
    written, last = [], ""
    for value in values:
        line, last = line_with_checksum(value, last)
        written.append(line)
    return b"".join(written)


@dataclass(frozen=True)
class Lines:
    """What a file of JSON lines holds.

    Parameters
    ----------
    values
        Its lines, without their checksums.
    checksums
        Those of the lines.
    torn
        Bytes of a last line that was cut short, as when its writer is killed; it is not among `values`.
    """

    values: tuple[dict[str, Any], ...] = ()
    checksums: tuple[str, ...] = ()
    torn: int = 0

    @property
    def end(self) -> dict[str, Any]:
        """How far it goes: how many lines, and the checksum of the last."""
        return {"lines": len(self.values), "checksum": self.checksums[-1] if self.checksums else ""}

    def check_reaches(self, end: Mapping[str, Any]) -> None:
        """Check that an earlier `end` lies in it.

        Raises
        ------
        Damaged
            When it is shorter, or was another file then.
        """
        count = end["lines"]
        if len(self.values) < count:
            raise Damaged(f"it has {len(self.values)} whole lines where {count} were written")
        if count and self.checksums[count - 1] != end["checksum"]:
            raise Damaged(f"its line {count} is not the one that was written")


def checked_lines(data: bytes) -> Lines:
    """The lines of a file; only a last one that was cut short is forgiven.

    Raises
    ------
    Damaged
        When any other line is not as it was written.
    """
    *whole, torn = data.split(b"\n")
    values, sums, last = [], [], ""
    for number, line in enumerate(whole, 1):
        found = _LINE.fullmatch(line)
        if found is None:
            raise Damaged(f"line {number} does not end with its checksum")
        if checksum(found[1], last) != found[2].decode():
            raise Damaged(f"the checksum of line {number} does not fit it and the lines before")
        last = found[2].decode()
        values.append(json_object(found[1] + b"}"))
        sums.append(last)
    return Lines(tuple(values), tuple(sums), len(torn))


def json_object(data: bytes) -> dict[str, Any]:
    """What a JSON object holds.

    Raises
    ------
    Damaged
        When it is none.
    """
    try:
        value = json.loads(data)
    except (ValueError, RecursionError) as error:  # a checksum that fits is no proof of good will
        raise Damaged(f"it is no JSON: {error}") from error
    if not isinstance(value, dict):
        raise Damaged("it is no JSON object")
    return value
