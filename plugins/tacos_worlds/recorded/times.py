"""Tables of a recording's frames: file, time and exposure, in the columns that programs write."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from tacos_files.dates import date_ns
from tacos_files.exposure_names import time_in_name_ms
from tacos_files.table_columns import EXPOSURE, FILE, Column, find_column
from tacos_framework import Fault
from tacos_framework.files import read_csv

TIMES = "times.csv"
_NANOSECOND = 1e-9
_EXPECTED = {
    _NANOSECOND: "a whole number of nanoseconds",
    None: "a date and a time of day: 2024-05-01T12:00:00.05",
}
_STAMP = ("taken", "timestamp", "stamp", "time", "t")


@dataclass(frozen=True)
class TimedFile:
    file: str
    stamp_ns: int
    exposure_ms: float | None  # by the table, else by the file's name; None where neither says
    where: str  # the line, for messages


def read_times(table: Path) -> tuple[list[TimedFile], list[Fault]]:
    """The lines of a table that can be read, and a fault for each other one; the files are not looked for.

    Raises UserError when it is no table of comma-separated values.
    """
    (_, first), *lines = read_csv(table) or [(1, [])]
    file, stamp, exposure = (find_column(first, names) for names in (FILE, _STAMP, EXPOSURE))
    if file is None or stamp is None:
        expected = "a column for the file (file) and one for the time (taken_ns, timestamp_us, time_s, ...)"
        return [], [Fault(f"{table}:1", f"has the columns {', '.join(first)}", expected)]
    faults = [
        Fault(f"{table}:1", f"the column {each.heading} states no unit", f"{each.heading}_ns, _us, _ms or _s")
        for each in (stamp, exposure)
        if each is not None and each.unit_s is None and not (each is stamp and _has_dates(each, lines))
    ]
    if faults:
        return [], faults
    found = []
    for number, cells in lines:
        where = f"{table}:{number}"
        name, taken = file.cell(cells), stamp.cell(cells)
        stated = exposure.cell(cells) if exposure else ""
        try:
            stamp_ns = _whole_ns(taken, stamp)
        except (ValueError, OverflowError):
            expected = _EXPECTED.get(stamp.unit_s, "a number")
            faults.append(Fault(where, f"has {stamp.heading} {taken!r}", expected))
            continue
        try:
            exposure_ms = exposure.seconds(stated) * 1e3 if exposure and stated else named_ms(name)
        except ValueError:
            heading = exposure.heading if exposure else ""
            faults.append(Fault(where, f"has {heading} {stated!r}", "a number, or a fraction of seconds"))
            continue
        if stamp_ns < 0 or (exposure_ms is not None and not 0 < exposure_ms < float("inf")):
            faults.append(
                Fault(where, f"names {name}, taken at {taken}, of {exposure_ms} ms", "more than 0 ms")
            )
            continue
        found.append(TimedFile(name, stamp_ns, exposure_ms, where))
    return found, faults


def named_ms(name: str) -> float | None:
    """Exposure in the name of a file, or else of its folder [ms].

    >>> [named_ms(name) for name in ("08ms_3.png", "left_500us_3.tif", "2.5ms/3.png", "3.png")]
    [8.0, 0.5, 2.5, None]
    """
    path = PurePosixPath(name.replace("\\", "/"))
    return next((ms for part in (path.stem, path.parent.name) if (ms := time_in_name_ms(part))), None)


def _whole_ns(text: str, column: Column) -> int:
    """Nanoseconds of a stamp; those that are stated so stay whole, which floats of 64 bits do not hold.

    Raises ValueError where it is neither a date nor a number that has a unit.
    """
    if (since_1970_ns := date_ns(text)) is not None:
        return since_1970_ns
    if column.unit_s is None:
        raise ValueError
    return int(text) if column.unit_s == _NANOSECOND else round(float(text) * column.unit_s / _NANOSECOND)


def _has_dates(column: Column, lines: list[tuple[int, list[str]]]) -> bool:
    return any(date_ns(column.cell(cells)) is not None for _, cells in lines[:1])
