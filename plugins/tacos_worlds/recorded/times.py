"""Tables of a recording's frames: file, time and exposure, in the columns that programs write."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from tacos_framework import Fault
from tacos_framework.files import read_csv

TIMES = "times.csv"
_FILE = ("file", "filename", "name", "image")
_STAMP_NS: Mapping[str, float] = {
    "taken_ns": 1,
    "timestamp_ns": 1,
    "stamp_ns": 1,
    "taken_us": 1e3,
    "timestamp_us": 1e3,
    "taken_ms": 1e6,
    "timestamp_ms": 1e6,
    "taken_s": 1e9,
    "time_s": 1e9,
    "timestamp_s": 1e9,
}
_UNIT_MS: Mapping[str, float] = {"ns": 1e-6, "us": 1e-3, "ms": 1, "s": 1e3}
_EXPOSURE_MS = {f"exposure_{unit}": scale for unit, scale in _UNIT_MS.items()}
_NAMED = (
    re.compile(r"^(?P<number>\d+_\d+)(?P<unit>ns|us|ms|s)(?=[_.-])", re.IGNORECASE),  # 0_5ms is 0.5 ms
    re.compile(r"(?<![\d.])(?P<number>\d+(?:\.\d+)?)(?P<unit>ns|us|ms|s)(?=[_.-])", re.IGNORECASE),
)


@dataclass(frozen=True)
class TimedFile:
    """A line of a table."""

    file: str
    stamp_ns: int
    exposure_ms: float | None  # by the table, else by the file's name; None where neither says
    where: str  # the line, for messages


def read_times(table: Path) -> tuple[list[TimedFile], list[Fault]]:
    """The lines of a table that can be read, and a fault for each other one; the files are not looked for.

    Raises UserError when it is no table of comma-separated values.
    """
    (_, first), *lines = read_csv(table) or [(1, [])]
    heads = [head.lower() for head in first]
    file = next((name for name in _FILE if name in heads), None)
    stamp = next((name for name in _STAMP_NS if name in heads), None)
    exposure = next((name for name in _EXPOSURE_MS if name in heads), None)
    if file is None or stamp is None:
        expected = f"a column for the file ({', '.join(_FILE)}) and one for the time ({', '.join(_STAMP_NS)})"
        return [], [Fault(f"{table}:1", f"has the columns {', '.join(first)}", expected)]
    found, faults = [], []
    for number, cells in lines:
        row, where = dict(zip(heads, cells, strict=False)), f"{table}:{number}"
        name, taken = row.get(file, ""), row.get(stamp, "")
        stated = row.get(exposure, "") if exposure else ""
        try:
            stamp_ns = int(taken) if _STAMP_NS[stamp] == 1 else round(float(taken) * _STAMP_NS[stamp])
            exposure_ms = float(stated) * _EXPOSURE_MS[exposure] if exposure and stated else named_ms(name)
        except (ValueError, OverflowError):
            what = f"has {stamp} {taken!r}" + (f" and {exposure} {stated!r}" if stated else "")
            whole = "a whole number of nanoseconds" if _STAMP_NS[stamp] == 1 else "numbers"
            faults.append(Fault(where, what, whole))
            continue
        if stamp_ns < 0 or (exposure_ms is not None and not 0 < exposure_ms < float("inf")):
            faults.append(
                Fault(where, f"names {name}, taken at {taken}, of {exposure_ms} ms", "more than 0 ms")
            )
            continue
        found.append(TimedFile(name, stamp_ns, exposure_ms, where))
    return found, faults


def named_ms(name: str) -> float | None:
    """Exposure in the name of a file [ms].

    >>> [named_ms(name) for name in ("08ms_3.png", "left_500us_3.tif", "0_5ms_3.png", "3.png")]
    [8.0, 0.5, 0.5, None]
    """
    for pattern in _NAMED:
        if found := pattern.search(Path(name).name):
            return float(found["number"].replace("_", ".")) * _UNIT_MS[found["unit"].lower()]
    return None
