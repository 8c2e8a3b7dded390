"""Text, JSON and tables of comma-separated values."""

from __future__ import annotations

import codecs
import csv
import json
import logging
import math
import re
from io import StringIO
from pathlib import Path
from typing import Any

from tacos_framework.errors import Fault, UserError
from tacos_framework.files.regular import read_bytes

CSV_SUFFIXES = (".csv", ".tsv")
"""Ends of the names of tables that `read_csv` reads."""

log = logging.getLogger(__name__)

_ANY_LINE = re.compile(r"\S.*")
_NO_REMARK = re.compile(r"^[^\S\n]*[^#\s].*", re.MULTILINE)
_STATED_MARK = re.compile(r'"?sep=([^\w\s"]|\t)"?[,;\t]*(?:\r\n|\r|\n)', re.IGNORECASE)
"""First line of a table that Excel reads in any country."""
_DECIMAL_COMMA = re.compile(r"[-+]?\d*,\d+([eE][-+]?\d+)?")


def decoded(content: bytes) -> tuple[str, UnicodeDecodeError | None]:
    """Text in UTF-8, or in UTF-16 with its byte order mark; else in Windows-1252, and why it is not UTF-8."""
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return content.decode("utf-16", "replace"), None
    try:
        return content.decode("utf-8-sig"), None
    except UnicodeDecodeError as error:
        return content.decode("cp1252", "replace"), error


def read_text(
    path: Path,
    *,
    where: str | None = None,
    limit: str = "text_mb",
    within: Path | None = None,
    guess: bool = False,
) -> str:
    """The text of a file in UTF-8 or UTF-16, without a byte order mark.

    - `guess`: whether other text is read as Windows-1252, as older spreadsheets write it; a warning says so.

    Other parameters are those of `tacos_framework.files.regular.read_bytes`.

    Raises `UserError` when it cannot be read, is too large, or is no such text.
    """
    content = read_bytes(path, limit, where=where, within=within)
    text, error = decoded(content)
    if error is None:
        return text
    name = str(path) if where is None else where
    if guess and b"\0" not in content and "\N{REPLACEMENT CHARACTER}" not in text:
        log.warning("%s is not in UTF-8, and is read as Windows-1252", name)
        return text
    line = content.count(b"\n", 0, error.start) + 1
    raise UserError(
        Fault(f"{name}:{line}", f"byte {content[error.start]:#04x} is not UTF-8", "text in UTF-8")
    ) from error


def read_json(path: Path, *, where: str | None = None, expected: str = "", remedy: str = "") -> Any:
    """The value in a JSON file.

    `expected`, `remedy`: of the fault, where the file is no JSON.

    Raises `UserError` when it cannot be read, is too large, or is no JSON.
    """
    name = str(path) if where is None else where
    return parse_json(read_text(path, where=where, limit="json_mb"), name, expected, remedy)


def read_lines(path: Path, *, where: str | None = None) -> list[str]:
    """The lines of a text file, such as one of JSON objects; a last one without its end is among them.

    Raises `UserError` as for `read_text`.
    """
    lines = read_text(path, where=where, limit="lines_mb").split("\n")  # text in JSON may hold other ends
    return lines[:-1] if not lines[-1] else lines


def parse_json(text: str, where: str, expected: str = "", remedy: str = "") -> Any:
    """The value in JSON text.

    Raises `UserError` when it is none, or nested too deeply.
    """
    try:
        return json.loads(text)
    except ValueError as error:  # JSONDecodeError, or a whole number of thousands of digits
        raise UserError(Fault(where, f"not readable as JSON: {error}", expected, remedy)) from error
    except RecursionError:
        raise UserError(Fault(where, "JSON nested too deeply to be read", expected, remedy)) from None


def read_csv(
    path: Path, *, where: str | None = None, within: Path | None = None
) -> list[tuple[int, list[str]]]:
    """The lines of a table with their numbers, cells without the blanks around them.

    Columns are parted by commas, semicolons (then numbers may have decimal commas) or tabs, as the first line
    that is no remark (#) tells: spreadsheets of many countries write these. A first line ``sep=;`` is obeyed,
    and left out.

    Raises `UserError` when it cannot be read or is no table.
    """
    text = read_text(path, where=where, within=within, guess=True)
    stated = _STATED_MARK.match(text)
    before, text = (1, text[stated.end() :]) if stated else (0, text)
    mark = stated[1] if stated else _mark_between_columns(text)
    table = csv.reader(StringIO(text, newline=""), delimiter=mark, strict=True, skipinitialspace=mark != "\t")
    try:
        return [(before + table.line_num, [_cell(cell, mark) for cell in line]) for line in table]
    except csv.Error as error:
        name = str(path) if where is None else where
        what = f"this is no table of comma-separated values: {error}"
        raise UserError(Fault(f"{name}:{before + table.line_num}", what)) from error


def read_rows(
    path: Path, *, where: str | None = None, within: Path | None = None
) -> tuple[list[str], list[tuple[int, dict[str, str]]]]:
    """The headings of a table in small letters, and the cells of each other line by them, with its number.

    Empty lines are left out, and the cells that a short line lacks. Raises `UserError` as for `read_csv`.
    """
    (_, first), *lines = read_csv(path, where=where, within=within) or [(1, [])]
    headings = [heading.lower() for heading in first]
    return headings, [
        (number, dict(zip(headings, cells, strict=False))) for number, cells in lines if any(cells)
    ]


def _mark_between_columns(text: str) -> str:
    line = (_NO_REMARK.search(text) or _ANY_LINE.search(text) or [""])[0]
    if ";" in line and all(
        "," not in cell or _DECIMAL_COMMA.fullmatch(cell.strip()) for cell in line.split(";")
    ):
        return ";"
    return "\t" if "\t" in line and "," not in line else ","


def _cell(cell: str, mark: str) -> str:
    cell = cell.strip()
    return cell.replace(",", ".") if mark == ";" and _DECIMAL_COMMA.fullmatch(cell) else cell


def finite_number(cell: str) -> float | None:
    """The number in a cell of a table; None where there is none, or it is not finite."""
    try:
        value = float(cell)
    except ValueError:
        return None
    return value if math.isfinite(value) else None
