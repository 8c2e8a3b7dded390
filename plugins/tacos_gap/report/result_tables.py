"""The results folder of a diagnosis from Python: tables as data frames of pandas, or as plain rows."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tacos_framework import Fault, Row, Tables, UserError

if TYPE_CHECKING:
    import pandas


@dataclass(frozen=True)
class DiagnosisResult:
    """Findings of a diagnosis, as tables.

    `causes` and `where` give data frames of pandas (the extra ``frames``); `rows` gives plain values.
    """

    data: Mapping[str, Any]
    """All of ``diagnosis.json``; ``docs/reference/results.md`` lists its keys."""

    @property
    def verdict(self) -> str:
        return str(self.data["verdict"])

    def causes(self) -> pandas.DataFrame:
        """A line for each parameter of each cause, best cause first, with its interval and unit."""
        return TABLES.frame(self, "causes")

    def where(self) -> pandas.DataFrame:
        """A line for each statistic that is significant: ``stage``, ``statistic``, ``z``, ``share``, ..."""
        return TABLES.frame(self, "where")

    def rows(self, table: str) -> list[Row]:
        """A table, ``causes`` or ``where``, as plain values.

        Raises `UserError` when there is no such table.
        """
        return TABLES.rows(self, table)

    def __repr__(self) -> str:
        causes = ", ".join(cause["effect"] for cause in self.data["causes"]) or "no cause"
        gap = self.data["gap"]
        return f"<diagnosis: {self.verdict}, {causes}; gap {gap['before']:.3g} -> {gap['after']:.3g} floors>"


def read_diagnosis(folder: str | Path) -> DiagnosisResult:
    """Findings of a diagnosis, from its results folder.

    Raises `UserError` when there is no readable ``result.json`` of a diagnosis.
    """
    from tacos_framework.store import read_result  # with numpy, which listing plugins does without

    data = read_result(Path(folder)).get("diagnosis")
    if not isinstance(data, dict):
        raise UserError(
            Fault(str(folder), "it is not the result of a diagnosis", "what tacos-run diagnose wrote")
        )
    return DiagnosisResult(data)


def _causes(result: DiagnosisResult) -> Iterator[Row]:
    for cause in result.data["causes"]:
        for name, found in cause["parameters"].items():
            low, high = found.get("ci") or (None, None)
            yield {
                "effect": cause["effect"],
                "present": cause["present"],
                "closure": cause["closure"]["value"],
                "parameter": name,
                "value": found["value"],
                "low": low,
                "high": high,
                "unit": found.get("unit"),
            }


def _where(result: DiagnosisResult) -> Iterator[Row]:
    for place in result.data["where"]:
        yield {**place, "captures": ", ".join(place["captures"])}


TABLES = Tables[DiagnosisResult]({"causes": _causes, "where": _where})
