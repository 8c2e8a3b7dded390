"""The results folder of a study from Python: tables as plain lists, or as data frames of pandas."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tacos_framework import Fault, UserError, did_you_mean

if TYPE_CHECKING:
    import pandas

Row = dict[str, Any]
"""A line of a table: words and numbers by the name of their column."""

TABLES = ("comparisons", "ranking", "importance", "curves", "front")


@dataclass(frozen=True)
class StudyResult:
    """What came out of a study.

    Parameters
    ----------
    data
        All of ``result.json``; ``docs/reference/results.md`` lists its keys.
    """

    data: Mapping[str, Any]

    @property
    def decision(self) -> Mapping[str, Any] | None:
        """The verdict with its certainty; None where there is none, and then `decision_absent` says why."""
        return self.data.get("decision")

    @property
    def decision_absent(self) -> str | None:
        """Why no winner is named, in a sentence."""
        return self.data.get("decision_absent")

    @property
    def comparisons(self) -> list[Row]:
        """A line for each product: ``against``, ``verdict``, ``difference``, ``low``, ``high``."""
        return [_with_ends(row, "interval") for row in self.data.get("comparisons", ())]

    @property
    def ranking(self) -> list[Row]:
        """A line for each part, best first: its fitness, interval, variables and P(better than a product)."""
        rows = []
        for entry in self.data.get("ranking", ()):
            row = _with_ends(entry, "ci")
            camera, better = row.pop("camera"), row.pop("p_better")
            row["unknown"] = ", ".join(row["unknown"])
            rows.append(
                {
                    **row,
                    **{f"p_better.{name}": p for name, p in better.items()},
                    **{name: _shown(value) for name, value in camera.items()},
                }
            )
        return rows

    @property
    def importance(self) -> list[Row]:
        """A line for each variable: ``variable``, ``unit``, ``first_order``, ``total``."""
        return [
            {key: value for key, value in entry.items() if key != "curve"}
            for entry in self.data.get("importance", ())
        ]

    @property
    def curves(self) -> list[Row]:
        """A line for each point of each variable's curve: ``variable``, ``value``, ``mean``, ..."""
        return [
            {"variable": entry["variable"], **point}
            for entry in self.data.get("importance", ())
            for point in entry["curve"]
        ]

    @property
    def front(self) -> list[Row]:
        """A line for each camera of the front, with the value of each objective."""
        rows = []
        for entry in self.data.get("front", {}).get("points", ()):
            row = _with_ends(entry, "ci")
            camera, values = row.pop("camera"), row.pop("values")
            rows.append({**row, **values, **{name: _shown(value) for name, value in camera.items()}})
        return rows

    def _repr_html_(self) -> str:
        """In a notebook: the verdict, and every camera with its fitness on the test scenes, best first."""
        said = self.decision["sentence"] if self.decision else self.decision_absent or ""
        tested = self.data.get("test", {})
        fitness = {name: tested.get(name, {}).get("fitness") for name in self.data["cameras"]}
        ranked = sorted(fitness, key=lambda name: -math.inf if (f := fitness[name]) is None else f)[::-1]
        rows = "".join(
            f"<tr><td>{escape(self.data['cameras'][name].get('title', name))}</td>"
            f"<td>{'' if (f := fitness[name]) is None else format(f, '.4g')}</td></tr>"
            for name in ranked
        )
        return f"<p>{escape(said)}</p><table><tr><th>camera</th><th>fitness</th></tr>{rows}</table>"

    def frame(self, table: str) -> pandas.DataFrame:
        """A table as a data frame.

        Parameters
        ----------
        table
            ``comparisons``, ``ranking``, ``importance``, ``curves`` or ``front``.

        Raises
        ------
        UserError
            When there is no such table, or pandas is not installed (the extra ``frames``).
        """
        if table not in TABLES:
            remedy = did_you_mean(table, TABLES)
            raise UserError(Fault("table", f"there is no table {table!r}", ", ".join(TABLES), remedy))
        try:
            import pandas
        except ImportError as error:
            fault = Fault(
                "pandas",
                "pandas is not installed, which data frames need",
                "the extra frames",
                "Install it: pip install tacos-framework[frames]; or take the table as a list.",
            )
            raise UserError(fault) from error
        return pandas.DataFrame(getattr(self, table))


def read_result(folder: str | Path) -> StudyResult:
    """The result of a study, from its results folder.

    Raises
    ------
    UserError
        When there is no readable ``result.json`` of a study.
    """
    from tacos_framework.store import read_result as read  # with numpy, which listing plugins does without

    data = read(Path(folder))
    if not isinstance(data.get("cameras"), dict):
        fault = Fault(str(folder), "it is not the result of a study", "a result.json with cameras", "")
        raise UserError(fault)
    return StudyResult(data)


def _with_ends(row: Mapping[str, Any], key: str) -> Row:
    """A line whose interval stands in two columns."""
    ends = row.get(key) or (None, None)
    return {**{k: v for k, v in row.items() if k != key}, "low": ends[0], "high": ends[1]}


def _shown(value: Any) -> Any:
    return value["name"] if isinstance(value, Mapping) and "name" in value else value
