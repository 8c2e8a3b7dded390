"""Tables of comparisons for the documentation: ``python scripts/tables_of_runs.py RUN...``.

Prints, in Markdown, what stands in the ``result.json`` of rank agreements and of comparisons of optimizers.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any


def lines_of(result: Mapping[str, Any]) -> Iterator[str]:
    """The lines of one run's tables.

    Raises
    ------
    ValueError
        When the run is of a procedure that has no tables here.
    """
    match result["procedure"]:
        case "procedure.rank-agreement":
            yield from _rank_agreement(result)
        case "procedure.compare-optimizers":
            yield from _optimizers(result)
        case other:
            raise ValueError(f"{result['name']} is of {other}, which has no tables for the documentation")


def _rank_agreement(result: Mapping[str, Any]) -> Iterator[str]:
    for light, tau in result["tau"].items():
        rows = [row for row in result["table"] if row["light"] == light]
        interval = result["tau_interval"][light]
        between = f" [{interval[0]:.2f}, {interval[1]:.2f}]" if interval else ""
        said = "no order" if tau is None else f"tau {tau:.2f}{between}"
        yield f"{result['study']}, {light}, {result['scenes']} scenes: {said}.\n"
        yield from _table(
            ("camera", "place", "place at full size", "fitness", "fitness at full size"),
            [
                (
                    r["camera"],
                    f"{r['rank_quick']:g}",
                    f"{r['rank_full']:g}",
                    _number(r["quick"]),
                    _number(r["full"]),
                )
                for r in rows
            ],
        )
        yield ""


def _optimizers(result: Mapping[str, Any]) -> Iterator[str]:
    standings = result["standings"]
    checkpoints = sorted({int(at) for each in standings for at in each["regret"]})
    regret = [
        (each["optimizer"], *(_spread(each["regret"].get(str(at)), 3) for at in checkpoints))
        for each in standings
    ]
    yield from _table(("regret after", *(f"{at} images" for at in checkpoints)), regret)
    yield ""
    others = list(standings[0]["ratios"])
    heads = ("optimizer", "images to the target", "reached by", *(f"times fewer than {o}" for o in others))
    rows = [
        (
            each["optimizer"],
            _spread(each["images"], 0, "never"),
            f"{each['reached']:.0%}",
            *(_ratio(each["ratios"][other]) for other in others),
        )
        for each in standings
    ]
    yield from _table(heads, rows)


def _table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterator[str]:
    yield f"| {' | '.join(heads)} |"
    yield f"|{' --- |' * len(heads)}"
    for row in rows:
        yield f"| {' | '.join(row)} |"


def _spread(found: Mapping[str, Any] | None, digits: int, if_infinite: str = "nothing yet") -> str:
    """A median with its quartiles; what a run has not done or reached stands in words."""
    if found is None:
        return "not run"
    low, median, high = (_number(found[part], digits, if_infinite) for part in ("low", "median", "high"))
    return median if low == median == high else f"{median} [{low}, {high}]"


def _ratio(found: Mapping[str, Any]) -> str:
    if found["value"] is None:
        return "not reached"
    return f"{'at least ' if found['at_least'] else ''}{found['value']:.1f}"


def _number(value: float | None, digits: int = 3, if_infinite: str = "none") -> str:
    return if_infinite if value is None else f"{value:.{digits}f}"


def main() -> None:
    """Print the tables of the runs that are named."""
    for folder in sys.argv[1:]:
        print("\n".join(lines_of(json.loads((Path(folder) / "result.json").read_text("utf-8")))))


if __name__ == "__main__":
    main()
