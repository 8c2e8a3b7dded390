"""Findings of the finished studies, row by row, over their seeds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from statistics import median
from typing import Any

from tacos_validation.studies_table.settings import SummaryColumn, TableRow


@dataclass(frozen=True, eq=False)
class StudyRun:
    study: str
    seed: int
    result: Mapping[str, Any]
    generations: Sequence[Mapping[str, Any]]

    @property
    def curve(self) -> tuple[list[int], list[float]]:
        """Images rendered and the best fitness so far, after each generation that has one."""
        images, best, spent = [], [], 0
        for line in self.generations:
            spent += int(line["frames"])
            if line["best"] is not None:
                images.append(spent)
                best.append(float(line["best"]["fitness"]))
        return images, best


@dataclass(frozen=True)
class SummaryCell:
    """A figure of the table over the seeds, or a word where it is none."""

    values: tuple[float | str, ...]  # one per run that has it
    published: float | str | None  # what is published; None where nothing is
    best: bool = False  # true if no row has a better one

    @property
    def middle(self) -> float | None:
        """The median of the figures; None where there are none."""
        figures = [value for value in self.values if isinstance(value, (int, float))]
        return float(median(figures)) if figures else None


@dataclass(frozen=True, eq=False)
class RowResult:
    title: str
    cells: tuple[SummaryCell, ...]
    runs: int


def look_up(result: Mapping[str, Any], camera: str, value: str) -> float | str | None:
    """A figure of a camera in the result of a study; None where it has none.

    - `value`: as `SummaryColumn.value`: a group and a name, which may go on inside a part of a catalog.

    >>> result = {"cameras": {"designed": {"camera": {"sensor": {"name": "IMX172"}}}}, "test": {}}
    >>> look_up(result, "designed", "camera.sensor.name")
    'IMX172'
    """
    group, _, name = value.partition(".")
    if group == "test":
        held: Any = result["test"].get(camera, {})
    else:
        held = result["cameras"].get(camera, {}).get(group, {})
    if name not in held and "." in name:
        first, _, name = name.partition(".")
        held = held.get(first, {})
    found = held.get(name) if isinstance(held, Mapping) else None
    return found if isinstance(found, (int, float, str)) else None


def findings(
    rows: Sequence[TableRow], columns: Sequence[SummaryColumn], runs: Sequence[StudyRun]
) -> tuple[RowResult, ...]:
    """The rows of the table; those of studies that were left out are missing."""
    found = []
    for row in rows:
        of_row = [run for run in runs if run.study == row.study]
        if not of_row:
            continue
        cells = []
        for column in columns:
            values = (look_up(run.result, row.camera, column.value) for run in of_row)
            known = tuple(value for value in values if value is not None)
            cells.append(SummaryCell(known, row.published.get(column.head)))
        found.append(RowResult(row.title, tuple(cells), len(of_row)))
    return _with_best(found, columns)


def _with_best(found: Sequence[RowResult], columns: Sequence[SummaryColumn]) -> tuple[RowResult, ...]:
    marked = [list(row.cells) for row in found]
    for number, column in enumerate(columns):
        middles = [cells[number].middle for cells in marked]
        known = [value for value in middles if value is not None]
        if column.better is None or len(known) < 2:
            continue
        best = min(known) if column.better == "lower" else max(known)
        for cells, value in zip(marked, middles, strict=True):
            if value == best:
                cells[number] = SummaryCell(cells[number].values, cells[number].published, best=True)
    return tuple(
        RowResult(row.title, tuple(cells), row.runs) for row, cells in zip(found, marked, strict=True)
    )
