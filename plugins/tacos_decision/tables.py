"""The results folder of a study from Python: tables as data frames of pandas, or as plain rows."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tacos_framework import Fault, Row, Tables, UserError

if TYPE_CHECKING:
    import pandas


@dataclass(frozen=True)
class StudyResult:
    """Outcome of a study, as tables.

    Each method gives a data frame of pandas (the extra ``frames``); `rows` gives the same as plain values.
    """

    data: Mapping[str, Any]
    """All of ``result.json``; ``docs/reference/results.md`` lists its keys."""
    searched: Sequence[Mapping[str, Any]] = ()
    """The lines of ``generations.jsonl`` and of ``products.jsonl``."""

    @property
    def decision(self) -> Mapping[str, Any] | None:
        """The verdict with its certainty; None where there is none, and then `decision_absent` says why."""
        return self.data.get("decision")

    @property
    def decision_absent(self) -> str | None:
        """Why no winner is named, in a sentence."""
        return self.data.get("decision_absent")

    def candidates(self) -> pandas.DataFrame:
        """A line for each camera that was scored in the search, the designed one's and each product's."""
        return self.frame("candidates")

    def episodes(self) -> pandas.DataFrame:
        """A line for each candidate and scene, with its scores there."""
        return self.frame("episodes")

    def test(self) -> pandas.DataFrame:
        """A line for the designed camera and each product: fitness and scores on unseen scenes."""
        return self.frame("test")

    def comparisons(self) -> pandas.DataFrame:
        """A line for each product: ``against``, ``verdict``, ``difference``, ``low``, ``high``."""
        return self.frame("comparisons")

    def ranking(self) -> pandas.DataFrame:
        """A line for each part, best first: its fitness, interval, variables and P(better than a product)."""
        return self.frame("ranking")

    def importance(self) -> pandas.DataFrame:
        """A line for each variable: ``variable``, ``unit``, ``first_order``, ``total``."""
        return self.frame("importance")

    def curves(self) -> pandas.DataFrame:
        """A line for each point of each variable's curve: ``variable``, ``value``, ``mean``, ..."""
        return self.frame("curves")

    def front(self) -> pandas.DataFrame:
        """A line for each camera of the front, with the value of each objective."""
        return self.frame("front")

    def rows(self, table: str) -> list[Row]:
        """A table, named as its method, as plain values.

        Raises `UserError` when there is no such table.
        """
        return TABLES.rows(self, table)

    def frame(self, table: str) -> pandas.DataFrame:
        """A table, named as its method, as a data frame.

        Raises `UserError` when there is no such table, or pandas is not installed (the extra ``frames``).
        """
        return TABLES.frame(self, table)

    def __repr__(self) -> str:
        said = self.decision["sentence"] if self.decision else self.decision_absent or "no decision"
        return f"<result of {self.data.get('name', 'a study')!r}: {said}>"

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


def read_result(folder: str | Path) -> StudyResult:
    """The result of a study, from its results folder.

    Raises `UserError` when there is no readable ``result.json`` of a study.
    """
    from tacos_framework.store import read_result as read  # with numpy, which listing plugins does without
    from tacos_framework.store import read_run_lines

    data = read(Path(folder))
    if not isinstance(data.get("cameras"), dict):
        fault = Fault(str(folder), "it is not the result of a study", "a result.json with cameras", "")
        raise UserError(fault)
    lines = [read_run_lines(Path(folder) / name) for name in ("generations.jsonl", "products.jsonl")]
    return StudyResult(data, [*lines[0], *lines[1]])


def _candidates(result: StudyResult) -> Iterator[Row]:
    for line, candidate in _scored(result):
        yield {
            **_whose(line),
            "key": candidate["key"],
            "fitness": candidate["fitness"],
            "failed": candidate["failed"],
            "images": candidate["images"],
            **{name: _shown(value) for name, value in candidate["camera"].items()},
            **candidate["derived"],
            **candidate["scores"],
        }


def _episodes(result: StudyResult) -> Iterator[Row]:
    for line, candidate in _scored(result):
        for episode, scores in candidate["episodes"].items():
            yield {**_whose(line), "key": candidate["key"], "episode": episode, **scores}


def _scored(result: StudyResult) -> Iterator[tuple[Mapping[str, Any], Mapping[str, Any]]]:
    """Each line of the search with each of its candidates."""
    return ((line, candidate) for line in result.searched for candidate in line["candidates"])


def _whose(line: Mapping[str, Any]) -> Row:
    return {"product": line.get("product"), "generation": line["generation"]}


def _test(result: StudyResult) -> Iterator[Row]:
    cameras = result.data.get("cameras", {})
    for name, scores in result.data.get("test", {}).items():
        yield {"camera": name, "title": cameras.get(name, {}).get("title", name), **scores}


def _comparisons(result: StudyResult) -> Iterator[Row]:
    return (_with_ends(row, "interval") for row in result.data.get("comparisons", ()))


def _ranking(result: StudyResult) -> Iterator[Row]:
    for entry in result.data.get("ranking", ()):
        row = _with_ends(entry, "ci")
        camera, better = row.pop("camera"), row.pop("p_better")
        row["unknown"] = ", ".join(row["unknown"])
        yield {
            **row,
            **{f"p_better.{name}": p for name, p in better.items()},
            **{name: _shown(value) for name, value in camera.items()},
        }


def _importance(result: StudyResult) -> Iterator[Row]:
    for entry in result.data.get("importance", ()):
        yield {key: value for key, value in entry.items() if key != "curve"}


def _curves(result: StudyResult) -> Iterator[Row]:
    for entry in result.data.get("importance", ()):
        yield from ({"variable": entry["variable"], **point} for point in entry["curve"])


def _front(result: StudyResult) -> Iterator[Row]:
    for entry in result.data.get("front", {}).get("points", ()):
        row = _with_ends(entry, "ci")
        camera, values = row.pop("camera"), row.pop("values")
        yield {**row, **values, **{name: _shown(value) for name, value in camera.items()}}


def _with_ends(row: Mapping[str, Any], key: str) -> Row:
    """A line whose interval stands in two columns."""
    ends = row.get(key) or (None, None)
    return {**{k: v for k, v in row.items() if k != key}, "low": ends[0], "high": ends[1]}


def _shown(value: Any) -> Any:
    return value["name"] if isinstance(value, Mapping) and "name" in value else value


TABLES = Tables[StudyResult](
    {
        "candidates": _candidates,
        "episodes": _episodes,
        "test": _test,
        "comparisons": _comparisons,
        "ranking": _ranking,
        "importance": _importance,
        "curves": _curves,
        "front": _front,
    }
)
