"""The report of several studies: the table with published figures beside, and how the searches went."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

from matplotlib.figure import Figure

from tacos_report.figures.canvas import NARROW_IN, draw, light_grid
from tacos_report.page import Detailed, Page, Paragraph, Section, Table, Warnings, in_both_widths
from tacos_report.palette import MUTED, camera_colour
from tacos_report.quantities import duration, number
from tacos_validation.harness import csv_text
from tacos_validation.studies_table.findings import RowResult, StudyRun, SummaryCell
from tacos_validation.studies_table.settings import StudiesConfig, SummaryColumn

_OF_CURVES = (
    "A line a run. The fitness is what each study saw when it was evaluated; where weights are trained "
    "or scenes change on the way, it is no yardstick between studies: the table is."
)


@dataclass(frozen=True, eq=False)
class TableOutcome:
    """Everything the report tells."""

    config: StudiesConfig
    rows: tuple[RowResult, ...]
    runs: tuple[StudyRun, ...]
    notes: tuple[str, ...]

    def as_data(self) -> dict[str, Any]:
        heads = [column.head for column in self.config.columns]
        return {
            "problem": self.config.problem,
            "table": [
                {
                    "title": row.title,
                    "runs": row.runs,
                    "ours": dict(zip(heads, (_plain(cell) for cell in row.cells), strict=True)),
                    "published": {
                        head: cell.published
                        for head, cell in zip(heads, row.cells, strict=True)
                        if cell.published is not None
                    },
                }
                for row in self.rows
            ],
            "studies": [
                {
                    "study": run.study,
                    "seed": run.seed,
                    "frames_rendered": run.result["frames_rendered"],
                    "seconds": run.result["seconds"],
                    "folder": folder_of(run.study, run.seed),
                }
                for run in self.runs
            ],
            "comparison_notes": list(self.notes),
        }


def folder_of(study: str, seed: int) -> str:
    return f"studies/{study}_{seed}"


def page(outcome: TableOutcome) -> Page:
    config = outcome.config
    seeds = len({run.seed for run in outcome.runs})
    middle = (
        f"Figures are medians over {seeds} seeds, with lowest and highest in brackets. " if seeds > 1 else ""
    )
    return Page(
        eyebrow="Studies compared",
        title=summary(outcome).splitlines()[0],
        lead=(
            f"{len(outcome.runs)} studies of the problem {config.problem}, tested on unseen scenes. "
            f"{middle}Each study's own report lies in its folder under studies/."
        ),
        sections=(
            Section("Results", (_table(outcome), *_differences(outcome))),
            Section(
                "How the searches went",
                (in_both_widths(partial(_curves, outcome), _OF_CURVES), _costs(outcome)),
            ),
        ),
    )


def summary(outcome: TableOutcome) -> str:
    lines = [_headline(outcome)]
    for row in outcome.rows:
        figures = (
            f"{column.head} {shown(cell, column)}"
            for column, cell in zip(outcome.config.columns, row.cells, strict=True)
        )
        lines.append(f"{row.title}: {', '.join(figures)}")
    return "\n".join(lines)


def table_csv(outcome: TableOutcome) -> str:
    rows = []
    for row in outcome.rows:
        for column, cell in zip(outcome.config.columns, row.cells, strict=True):
            ordered = sorted(value for value in cell.values if isinstance(value, (int, float)))
            low, high = (ordered[0], ordered[-1]) if ordered else ("", "")
            own = (row.title, column.head, column.unit, _plain(cell), low, high, row.runs, cell.published)
            rows.append(own)
    return csv_text(("row", "column", "unit", "median", "lowest", "highest", "runs", "published"), rows)


def shown(cell: SummaryCell, column: SummaryColumn) -> str:
    if not cell.values:
        return "not known"
    if cell.middle is None:
        return ", ".join(dict.fromkeys(map(str, cell.values)))
    middle = number(cell.middle, column.digits)
    figures = [value for value in cell.values if isinstance(value, (int, float))]
    if len(figures) > 1 and min(figures) < max(figures):
        middle += f" [{number(min(figures), column.digits)}, {number(max(figures), column.digits)}]"
    return middle


def _plain(cell: SummaryCell) -> float | str | None:
    if cell.middle is not None:
        return cell.middle
    return str(cell.values[0]) if cell.values else None


def _headline(outcome: TableOutcome) -> str:
    """The best row, by the first column in which one alone is best."""
    for number_, column in enumerate(outcome.config.columns):
        best = [row for row in outcome.rows if row.cells[number_].best]
        if len(best) == 1:
            figure = shown(best[0].cells[number_], column)
            return f"{best[0].title} has the best {column.head.lower()}: {figure}"
    return f"{len(outcome.rows)} cameras side by side"


def _table(outcome: TableOutcome) -> Table:
    columns = outcome.config.columns
    marks = {"lower": " ↓", "higher": " ↑", None: ""}
    heads = [f"{c.head}{f' [{c.unit}]' if c.unit else ''}{marks[c.better]}" for c in columns]
    rows = tuple(
        (row.title, *(_cell(cell, column) for cell, column in zip(row.cells, columns, strict=True)))
        for row in outcome.rows
    )
    compared = any(cell.published is not None for row in outcome.rows for cell in row.cells)
    below = f" In small print: {outcome.config.published_in or 'published figures'}." if compared else ""
    return Table(("Camera", *heads), rows, f"Cameras on unseen scenes.{below}")


def _cell(cell: SummaryCell, column: SummaryColumn) -> str | Detailed:
    text = f"{shown(cell, column)}{' (best)' if cell.best else ''}"
    if cell.published is None:
        return text
    published = cell.published
    return Detailed(text, published if isinstance(published, str) else number(published, column.digits))


def _differences(outcome: TableOutcome) -> list[Paragraph | Warnings]:
    notes = (*outcome.config.differs, *outcome.notes)
    return [Warnings("What to know before comparing with published figures", notes)] if notes else []


def _curves(outcome: TableOutcome, *, narrow: bool = False) -> str:
    """SVG of a line per run: the best fitness so far against images rendered."""
    names = list(dict.fromkeys(run.study for run in outcome.runs))

    def paint(figure: Figure) -> None:
        axes = figure.add_subplot()
        for run in outcome.runs:
            images, best = run.curve
            first = run is next(other for other in outcome.runs if other.study == run.study)
            axes.step(
                images,
                best,
                where="post",
                color=camera_colour(names.index(run.study)),
                linewidth=2,
                label=run.study if first else "_again",
            )
        axes.set_xlabel("images rendered")
        axes.set_ylabel("best fitness so far")
        light_grid(axes, "y")
        if narrow:
            figure.legend(loc="outside lower left", ncols=1, labelcolor=MUTED)
        else:
            axes.legend(ncols=3, labelcolor=MUTED)

    described = f"Best fitness so far of {', '.join(names)} against images rendered."
    if narrow:
        return draw("curves-narrow", (NARROW_IN, 3.0 + 0.2 * len(names)), described, paint)
    return draw("curves", (9.2, 4.2), described, paint)


def _costs(outcome: TableOutcome) -> Table:
    rows = tuple(
        (
            run.study,
            str(run.seed),
            str(run.result["evaluations"]),
            str(run.result["frames_rendered"]),
            duration(float(run.result["seconds"])),
            str(run.result["stopped"]),
        )
        for run in outcome.runs
    )
    return Table(("Study", "Seed", "Evaluations", "Images", "Time", "Stopped"), rows)
