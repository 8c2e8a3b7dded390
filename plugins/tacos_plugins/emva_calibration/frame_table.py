"""``frames.csv``: which frame was taken of what, with every fault at once."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from tacos_files.table_columns import EXPOSURE, FILE, Column, find_column
from tacos_framework import Fault, UserError
from tacos_framework.files import named_file, read_csv

TABLE = "frames.csv"
_COLUMNS = "kind,exposure_ns,photons_per_pixel,file (photons_per_pixel may be empty)"
_EXPOSURES = "exposure_ns (or exposure_us, exposure_ms, exposure_s)"
_KINDS = ("bright", "dark")
_SAME = {"light": "bright", "flat": "bright", "bias": "dark"}
"""Other words for kinds."""
_HEADINGS = {
    "kind": ("kind", "type", "frametype", "imagetype"),
    "exposure": EXPOSURE,
    "photons_per_pixel": ("photonsperpixel", "photons", "meanphotons", "meanphotonsperpixel"),
    "file": FILE,
    "level": ("level",),
}
_UNKNOWN = {"", "-", "?", "nan", "na", "n/a", "none", "unknown"}
"""Cells that leave photons open, as programs write them."""
_ONE_LEVEL = 0.01
"""Exposures and photons of frames of one level may differ by this share [1]."""


@dataclass(frozen=True)
class FrameGroup:
    """Frames of one light and one exposure."""

    kind: str
    """``bright`` or ``dark``."""
    exposure_s: float
    """Exposure time [s]."""
    photons: float | None
    """Mean number of photons that hit a pixel [1]; None where that is not known."""
    level: str
    """Name of the light, where the table has a column ``level``."""
    files: tuple[Path, ...]
    """In the order of the table."""

    def __str__(self) -> str:
        of_light = f", {self.photons:g} photons" if self.photons else ""
        return (
            f"{self.kind} at {self.exposure_s * 1e3:g} ms{of_light}{self.level and f', level {self.level}'}"
        )


@dataclass(frozen=True)
class FrameTable:
    """A table as read: the groups of its sound lines, what is wrong with the others, columns without use."""

    groups: tuple[FrameGroup, ...]
    faults: tuple[Fault, ...]
    unread: tuple[str, ...]


def read_frame_table(folder: Path) -> FrameTable:
    """The groups of frames that a folder's table lists, by kind and exposure, and faults of its lines.

    Raises `UserError` when there is no table, or it lacks a column.
    """
    path = folder / TABLE
    if not path.is_file():
        what = f"there is no {TABLE} in this folder" if folder.is_dir() else "there is no such folder"
        remedy = "Write a line for each frame; docs/how-to/calibrate_a_camera.md has an example."
        raise UserError(Fault(str(folder), what, f"a folder of frames with {TABLE}: {_COLUMNS}", remedy))
    (_, first), *lines = read_csv(path) or [(1, [])]
    columns = {name: found for name, names in _HEADINGS.items() if (found := find_column(first, names))}
    missing = [name for name in ("kind", "file") if name not in columns]
    if "exposure" not in columns:
        missing.append(_EXPOSURES)
    faults = []
    if missing:
        there = f"; its columns are {', '.join(first)}" if first else ""
        faults.append(Fault(f"{path}:1", f"there is no column {', '.join(missing)}{there}", _COLUMNS))
    elif columns["exposure"].unit_s is None:
        what = f"the column {columns['exposure'].heading!r} names no unit of time"
        faults.append(Fault(f"{path}:1", what, _EXPOSURES, "Write the unit into the heading."))
    if faults:
        raise UserError(faults)
    reader = _Reader(folder, columns["exposure"])
    for number, cells in lines:
        if any(cells):
            reader.take(f"{path}:{number}", {name: column.cell(cells) for name, column in columns.items()})
    reader.finish(path)
    read = {column.place for column in columns.values()}
    unread = tuple(heading for place, heading in enumerate(first) if heading and place not in read)
    return FrameTable(reader.groups(), tuple(reader.faults), unread)


class _Reader:
    """Takes line after line, keeping faults."""

    def __init__(self, folder: Path, exposure: Column):
        self.folder = folder
        self.exposure = exposure
        self.faults: list[Fault] = []
        self._found: dict[tuple[str, float, float | None, str], list[Path]] = {}
        self._seen: dict[Path, str] = {}
        self._photons: list[tuple[str, bool]] = []

    def take(self, where: str, row: Mapping[str, str]) -> None:
        before = len(self.faults)
        kind, name = row.get("kind", "").lower(), row.get("file", "")
        kind = _SAME.get(kind, kind)
        if kind not in _KINDS:
            self.faults.append(Fault(where, f"kind is {kind or 'empty'!r}", "bright or dark"))
        exposure_s = self._number(where, self.exposure.heading, row["exposure"], self.exposure.seconds)
        given = row.get("photons_per_pixel", "")
        known = given.lower() not in _UNKNOWN
        photons = self._number(where, "photons_per_pixel", given) if known else None
        if kind == "dark":
            if photons:
                self.faults.append(Fault(where, f"a dark frame has {photons:g} photons", "0, or nothing"))
            photons = None
        elif kind == "bright":
            self._photons.append((where, photons is not None))
            if photons == 0:
                self.faults.append(Fault(where, "a bright frame has 0 photons", "kind: dark, or its photons"))
        path = self._file(where, name)
        if len(self.faults) == before and exposure_s is not None:
            key = (kind, exposure_s, photons, row.get("level", ""))
            self._found.setdefault(key, []).append(path)

    def _number(
        self, where: str, column: str, text: str, value_of: Callable[[str], float] = float
    ) -> float | None:
        try:
            value = value_of(text)
        except ValueError:
            value = math.nan
        if math.isfinite(value) and value >= 0:
            return value
        self.faults.append(Fault(where, f"{column} is {text or 'empty'!r}", "a number, 0 or above"))
        return None

    def _file(self, where: str, name: str) -> Path:
        path = named_file(self.folder, name) or self.folder / name
        if not name:
            self.faults.append(Fault(where, "file is empty", "the name of a frame in this folder"))
        elif path in self._seen:
            self.faults.append(Fault(where, f"{name!r} stands twice, as in {self._seen[path]}", "each once"))
        elif not path.is_file():
            remedy = "Copy it into the folder, or take its line out of the table."
            what = f"there is no file {name!r}"
            self.faults.append(Fault(where, what, f"a frame in {self.folder}", remedy))
        self._seen.setdefault(path, where.rpartition(":")[2])
        return path

    def finish(self, path: Path) -> None:
        """Look for what only the whole table shows."""
        known = [is_known for _, is_known in self._photons]
        if any(known) and not all(known):
            lacking = [where.rpartition(":")[2] for where, is_known in self._photons if not is_known]
            what = f"photons_per_pixel is empty in {len(lacking)} bright lines ({', '.join(lacking[:5])})"
            self.faults.append(Fault(str(path), what, "photons of all bright frames, or of none"))
        kinds = Counter(kind for kind, *_ in self._found)
        for kind in _KINDS:
            if not kinds[kind] and not self.faults:
                remedy = (
                    "Cover the lens, and take two frames." if kind == "dark" else "Take two frames a level."
                )
                self.faults.append(Fault(str(path), f"there are no {kind} frames", f"kind: {kind}", remedy))

    def groups(self) -> tuple[FrameGroup, ...]:
        ordered = sorted(self._found.items(), key=lambda item: (item[0][0], item[0][1], item[0][2] or 0.0))
        return tuple(_joined(FrameGroup(*key, tuple(files)) for key, files in ordered))


def _joined(groups: Iterable[FrameGroup]) -> list[FrameGroup]:
    """Groups, frames that stand alone joined: meters give each frame a figure of its own."""
    found: list[FrameGroup] = []
    alone = False
    for group in groups:
        if alone and len(group.files) == 1 and _alike(found[-1], group):
            found[-1] = replace(found[-1], files=(*found[-1].files, *group.files))
        else:
            found.append(group)
            alone = len(group.files) == 1
    return found


def _alike(one: FrameGroup, other: FrameGroup) -> bool:
    pairs = [(one.exposure_s, other.exposure_s), (one.photons or 0.0, other.photons or 0.0)]
    same = (one.kind, one.level) == (other.kind, other.level)
    return same and all(math.isclose(*pair, rel_tol=_ONE_LEVEL) for pair in pairs)
