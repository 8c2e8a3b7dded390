"""Systems that engineers use for a job, from a table: a word or a range for each point."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from tacos_framework import Constraint, Fault, UserError
from tacos_framework.files import read_rows

SHIPPED = Path(__file__).with_name("industry.csv")
"""34 systems, each with its source: calibration files, drivers, documentation."""

AGREED = 0.75
"""A word is the industry's where this share of the systems that state one have it."""

_NUMBER = re.compile(r"(?:^|\b(?:about|more than|reaches) )(\d+(?:\.\d+)?)\b")
"""A number at the start of a cell, or behind one of the words with which sources round it."""

System = Mapping[str, str]
"""A line of the table by its columns."""


@dataclass(frozen=True)
class Point:
    """Something that systems of a job have in common."""

    quantity: str  # what a study calls it, as constraints do
    columns: tuple[str, ...]  # columns of the table whose product it is
    unit: str = ""  # unit of the quantity; empty for words
    scale: float = 1.0  # the quantity over that product
    margin: float = 1.0
    """Factor below the least and above the greatest system that still counts as the same class."""


POINTS: Mapping[str, Point] = {
    "shutter": Point("sensor.shutter", ("shutter",)),
    "colour": Point("sensor.colour", ("colour",)),
    "pixel": Point("sensor.pixel_um", ("pixel_um",), "um", margin=1.25),
    "pixels": Point("megapixels", ("width_px", "height_px"), "Mpx", 1e-6, margin=2),
    "field": Point("hfov_deg", ("hfov_deg",), "deg", margin=1.25),
    "baseline": Point("baseline_m", ("baseline_mm",), "m", 1e-3, margin=1.5),
}
"""Margins are a step of what is sold: pitches 1.4, 1.75, 2.2, 2.8, 3.45 um; sizes .3, 1, 2 Mpx."""


@dataclass(frozen=True)
class IndustryAnswer:
    """The class of cameras that the industry has at one point."""

    point: str
    within: Constraint  # what a camera of that class keeps
    said: str  # the same in words
    systems: tuple[str, ...]  # the systems that state it


def read_systems(path: Path) -> list[System]:
    """The lines of a table of systems. Raises UserError with the columns that are missing."""
    heading, lines = read_rows(path)
    needed = ("job", "system", *(column for point in POINTS.values() for column in point.columns))
    if missing := [name for name in needed if name not in heading]:
        fault = Fault(
            str(path), f"the first line has no column {', '.join(missing)}", f"columns {', '.join(needed)}"
        )
        raise UserError(fault)
    return [row for _, row in lines]


def industry_answer(name: str, systems: Sequence[System]) -> IndustryAnswer | None:
    """Answer that systems of one job share at a point; None where they state nothing, or no one thing."""
    point = POINTS[name]
    if point.unit:
        return _range(name, point, systems)
    stated = [
        (row["system"], row[point.columns[0]].split(" ")[0]) for row in systems if row[point.columns[0]]
    ]
    if not stated:
        return None
    word, count = Counter(word for _, word in stated).most_common(1)[0]
    if count < AGREED * len(stated):
        return None
    said = f"{word} ({count} of {len(stated)})"
    return IndustryAnswer(
        name, Constraint(point.quantity, any_of=(word,), unknown="refuse"), said, tuple(s for s, _ in stated)
    )


def _range(name: str, point: Point, systems: Sequence[System]) -> IndustryAnswer | None:
    stated = {row["system"]: value for row in systems if (value := _value(point, row)) is not None}
    if not stated:
        return None
    least, most = min(stated.values()), max(stated.values())
    within = Constraint(point.quantity, least / point.margin, most * point.margin, unknown="refuse")
    span = f"{least:.3g}" if least == most else f"{least:.3g} to {most:.3g}"
    count = "1 system" if len(stated) == 1 else f"{len(stated)} systems"
    return IndustryAnswer(name, within, f"{span} {point.unit} ({count})", tuple(stated))


def _value(point: Point, system: System) -> float | None:
    value = point.scale
    for column in point.columns:
        if (found := _NUMBER.search(system[column])) is None:
            return None
        value *= float(found.group(1))
    return value
