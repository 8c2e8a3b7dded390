"""Tables that lie beside photographs: exposure times and gains by the names of files, or in their order."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from tacos_framework import UserError
from tacos_framework.files import read_text
from tacos_gap.captures.files import by_number
from tacos_gap.photographs.names import kind_in_words

TABLE_SUFFIXES = frozenset({".csv", ".tsv", ".txt", ".lst", ".list"})

_MS = {
    "ns": 1e-6,
    "us": 1e-3,
    "\u00b5s": 1e-3,
    "\u03bcs": 1e-3,
    "ms": 1.0,
    "s": 1e3,
    "sec": 1e3,
    "seconds": 1e3,
}
_OF_TIMES = re.compile(
    r"exp(?!ect)|shutter|integration|t_?int|duration|(?<![a-z])times?(?![a-z_]*st)", re.IGNORECASE
)
_OF_EXPOSURES = re.compile(r"exp|shutter|integration|t_?int", re.IGNORECASE)
_OF_MOMENTS = re.compile(r"stamp|taken|date|clock|utc|posix|epoch|created|modified", re.IGNORECASE)
_UNIT = re.compile(r"(?<![a-z])(ns|us|\u00b5s|\u03bcs|ms|sec|seconds|s)(?![a-z])", re.IGNORECASE)
_CELL = re.compile(
    r"(?:(1)\s*/\s*)?(\d+(?:\.\d*)?(?:e[-+]?\d+)?|\.\d+)\s*(ns|us|\u00b5s|\u03bcs|ms|sec|seconds|s)?\"?",
    re.IGNORECASE,
)
_KIND = re.compile(r"(?<![a-z])(kind|type|class|what)(?![a-z])", re.IGNORECASE)
_ISO, _GAIN, _F_NUMBER = (
    re.compile(p, re.IGNORECASE)
    for p in (r"(?<![a-z])iso", r"gain.*db|(?<![a-z])db", r"f_?(number|stop|-stop)|aperture")
)


@dataclass(frozen=True)
class Row:
    """Settings of one picture in a table; None where it has none."""

    time: float | None = None
    """Its number for the exposure time, before any unit but those of the cell itself."""
    ms_per_unit: float | None = None
    """What the number counts, where cell or heading say it [ms]; None leaves it open."""
    iso: float | None = None  # [1]
    gain_db: float | None = None
    f_number: float | None = None  # [1]
    kind: str | None = None  # dark or flat


@dataclass(frozen=True)
class Table:
    """A table of pictures."""

    path: Path
    rows: Mapping[Path, Row]  # by the picture's file
    named: bool  # whether the table names its files, rather than listing numbers in their order


def tables_among(others: Sequence[Path], pictures: Sequence[Path]) -> list[Table]:
    """The tables among files that are no pictures, each of pictures in its own folder or below."""
    tables = []
    for path in others:
        if path.suffix.lower() not in TABLE_SUFFIXES:
            continue
        near = [picture for picture in pictures if picture.is_relative_to(path.parent)]
        try:
            lines = read_text(path, guess=True).splitlines()
        except UserError:  # a file of another kind: it is passed over as such
            continue
        if rows := _by_name(lines, near):
            tables.append(Table(path, rows, named=True))
        elif rows := _in_order(lines, [p for p in near if p.parent == path.parent]):
            tables.append(Table(path, rows, named=False))
    return tables


class PicturesByName:
    """Pictures by how a table may name them: with or without their folders and suffixes, in any case."""

    def __init__(self, pictures: Sequence[Path]) -> None:
        stems = Counter(picture.stem.lower() for picture in pictures)
        alone = [p for p in pictures if stems[p.stem.lower()] == 1 and not p.stem.isdecimal()]
        self._by_name = {p.stem.lower(): p for p in alone} | {p.name.lower(): p for p in pictures}

    def get(self, text: str) -> Path | None:
        return self._by_name.get(re.split(r"[\\/]", text.lower())[-1])


def _by_name(lines: Sequence[str], pictures: Sequence[Path]) -> dict[Path, Row]:
    """Rows of a table in which one column names pictures."""
    named = PicturesByName(pictures)
    cells = [_cells(line) for line in lines]
    found: dict[Path, Row] = {}
    heading: list[str] = []
    for row in cells:
        at = next((i for i, cell in enumerate(row) if named.get(cell)), None)
        if at is None:
            heading = row if row and not found and not _is_number(row[-1]) else heading
            continue
        picture, rest = named.get(row[at]), heading if len(heading) == len(row) else []
        values = row_of(row, rest, at)
        if picture is not None and values != Row():
            found[picture] = values
    return found


def _in_order(lines: Sequence[str], pictures: Sequence[Path]) -> dict[Path, Row]:
    """Rows of a list of nothing but numbers, as many as there are pictures."""
    cells = [row for line in lines if (row := _cells(line))]
    heading = cells.pop(0) if cells and not _is_number(cells[0][0]) else []
    if len(cells) != len(pictures) or any(len(row) != 1 or not _is_number(row[0]) for row in cells):
        return {}
    if heading and not _counts_times(heading[-1]):
        return {}
    rows = [row_of(["", *row], ["", heading[-1]] if heading else [], 0) for row in cells]
    return dict(zip(sorted(pictures, key=by_number), rows, strict=True))


def _cells(line: str) -> list[str]:
    """Cells between commas, semicolons or tabs, or else between blanks; a unit belongs to its number."""
    line = line.strip().lstrip("#;/%").strip()
    if re.search(r"[,;\t]", line):
        return [cell.strip("\"' ") for cell in re.split(r"[,;\t]", line)]
    cells: list[str] = []
    for word in line.split():
        if cells and _UNIT.fullmatch(word) and _is_number(cells[-1]):
            cells[-1] += word
        else:
            cells.append(word.strip("\"'"))
    return cells


def row_of(cells: Sequence[str], heading: Sequence[str], file_at: int | None = None) -> Row:
    """Row of cells: those whose heading says a setting, or without headings the first number.

    `file_at`: the cell that names the picture, if any does.
    """
    others = [i for i in range(len(cells)) if i != file_at]
    if not heading:
        first = next((i for i in others if _is_number(cells[i])), None)
        return Row() if first is None else Row(*_time(cells[first], ""))
    said: dict[str, float | None] = {}
    times = [i for i in others if _counts_times(heading[i]) and _is_number(cells[i])]
    timed = next((i for i in times if _OF_EXPOSURES.search(heading[i])), next(iter(times), None))
    time, unit = (None, None) if timed is None else _time(cells[timed], heading[timed])
    for key, pattern in (("iso", _ISO), ("gain_db", _GAIN), ("f_number", _F_NUMBER)):
        at = next((i for i in others if i != timed and pattern.search(heading[i])), None)
        number = None if at is None else _CELL.fullmatch(cells[at].lower().lstrip("f/").removesuffix("db"))
        said[key] = float(number[2]) if number else None
    kinds = (kind_in_words(cells[i]) for i in others if _KIND.search(heading[i]))
    return Row(time, unit, **said, kind=next(kinds, None))


def _counts_times(heading: str) -> bool:
    return bool(_OF_TIMES.search(heading)) and not _OF_MOMENTS.search(heading)


def _is_number(cell: str) -> bool:
    return _CELL.fullmatch(cell) is not None


def _time(cell: str, heading: str) -> tuple[float | None, float | None]:
    """A number and what it counts [ms]: ``1/60`` counts seconds, ``1/t`` in the heading their inverse."""
    found = _CELL.fullmatch(cell)
    if found is None or not float(found[2]):
        return None, None
    one, number, unit = found.groups()
    of_heading = _UNIT.search(heading.replace("_", " "))
    unit = unit or (of_heading and of_heading[1])
    value = 1 / float(number) if one else float(number)
    return value, _MS[unit.lower()] if unit else 1e3 if one else None
