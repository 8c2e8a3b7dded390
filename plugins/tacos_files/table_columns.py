"""Columns of tables by their headings, however programs write them."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

FILE = ("file", "filename", "name", "image", "path", "frame")
EXPOSURE = ("exposure", "exposuretime", "exp", "shutter", "shuttertime", "integrationtime")
_SECONDS: Mapping[str, float] = {
    "ns": 1e-9,
    "us": 1e-6,
    "\u00b5s": 1e-6,
    "\u03bcs": 1e-6,
    "ms": 1e-3,
    "s": 1.0,
}


@dataclass(frozen=True)
class Column:
    place: int
    heading: str  # as it stands in the table
    unit_s: float | None  # what its numbers count [s]; None where the heading names no unit of time

    def cell(self, cells: Sequence[str]) -> str:
        """Its cell in a line; empty where the line ends before."""
        return cells[self.place] if self.place < len(cells) else ""

    def seconds(self, cell: str) -> float:
        """The time in a cell [s]; a fraction such as 1/125 in a column of seconds.

        Raises ValueError where there is none.
        """
        above, slash, below = cell.partition("/")
        if slash and self.unit_s == 1 and float(below):
            return float(above) / float(below)
        return float(cell) * (self.unit_s or 1)


def find_column(headings: Sequence[str], names: Sequence[str]) -> Column | None:
    """The column of the first of some names, whatever case, marks and unit of time its heading has.

    >>> find_column(["#Time Stamp [ns]", "file"], ("timestamp",))
    Column(place=0, heading='#Time Stamp [ns]', unit_s=1e-09)
    """
    split = [re.findall(r"[^\W\d_]+", heading.lower()) for heading in headings]
    for name in names:
        for place, words in enumerate(split):
            unit = _SECONDS.get(words[-1]) if len(words) > 1 else None
            if "".join(words[:-1] if unit else words) == name:
                return Column(place, headings[place], unit)
    return None
