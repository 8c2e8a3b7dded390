"""Noise of cameras over their gain, from a table of measurements."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Fault, UserError
from tacos_framework.files import finite_number, read_rows

COLUMNS = ("maker", "model", "iso", "a", "b")
_MOST_FAULTS = 20


@dataclass(frozen=True, eq=False)
class MeasuredCamera:
    """Variance ``a x + b`` of one camera, x as a share of full scale."""

    name: str
    gains: NDArray[np.float64]  # (N,) linear gains, as ISO values [1]
    slopes: NDArray[np.float64]  # (N,) a [1]
    intercepts: NDArray[np.float64]  # (N,) b [1]

    def __len__(self) -> int:
        return len(self.gains)

    def without_gain(self, gain: float) -> MeasuredCamera:
        kept = self.gains != gain
        return MeasuredCamera(self.name, self.gains[kept], self.slopes[kept], self.intercepts[kept])


def read_gain_table(path: Path) -> list[MeasuredCamera]:
    """Cameras of a CSV file with the columns maker, model, iso, a and b, in the order of the file.

    Raises UserError with all faults of the file: missing columns, values that are no numbers, gains not above
    0.
    """
    heading, lines = read_rows(path)
    missing = [name for name in COLUMNS if name not in heading]
    if missing:
        raise UserError(
            Fault(
                str(path),
                f"the first line has no column {', '.join(missing)}",
                f"columns {', '.join(COLUMNS)}, separated by commas",
                "a and b: variance = a x + b, with x and the variance over full scale.",
            )
        )
    cameras = _gathered(path, lines)
    if not cameras:
        raise UserError(Fault(str(path), "has no measurements", "a line for each camera and gain"))
    return cameras


def _gathered(path: Path, rows: Iterable[tuple[int, Mapping[str, str]]]) -> list[MeasuredCamera]:
    faults: list[Fault] = []
    measured: dict[str, list[tuple[float, float, float]]] = {}
    for line, row in rows:
        found = list(_faults_of(f"{path}, line {line}", row))
        faults += found
        if not found:
            name = f"{row['maker']} {row['model']}".strip()
            gain, slope, intercept = (float(row[key]) for key in ("iso", "a", "b"))
            measured.setdefault(name, []).append((gain, slope, intercept))
    if faults:
        raise UserError(faults[:_MOST_FAULTS])
    columns = {name: np.array(sorted(values)).T for name, values in measured.items()}
    return [MeasuredCamera(name, *values) for name, values in columns.items()]


def _faults_of(where: str, row: Mapping[str, str]) -> Iterator[Fault]:
    for column in ("iso", "a", "b"):
        value = finite_number(row.get(column, ""))
        if value is None:
            yield Fault(where, f"{column} is {row.get(column, '')!r}", "a finite number")
        elif column == "iso" and value <= 0:
            yield Fault(where, f"iso is {value:g}", "a gain above 0")
