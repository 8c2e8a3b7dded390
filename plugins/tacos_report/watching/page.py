"""A page of a running study that reloads itself until the study has ended."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from tacos_report.figures.search_curve import search_curve
from tacos_report.page import Block, Code, Page, Paragraph, Section, Table, in_both_widths, write_page
from tacos_report.watching.in_words import HEADS, ranking, state
from tacos_report.watching.running_study import RunningStudy


def write_watch_page(path: Path, study: RunningStudy, *, now_s: float, every_s: float) -> None:
    """Write the page of a moment; it reloads every so many seconds while the study runs."""
    write_page(
        path,
        Page(
            eyebrow="A study that runs" if study.stopped is None else "A study that has ended",
            title=study.name,
            lead=state(study, now_s),
            sections=_sections(study),
            reload_s=every_s if study.stopped is None else None,
        ),
    )


def _sections(study: RunningStudy) -> list[Section]:
    if not study.ranking:
        return [Section("Best so far", (Paragraph("No candidate has been scored yet."), *_log(study)))]
    curve = in_both_widths(
        partial(search_curve, study.generations), "Each dot is a candidate; the line is the best so far."
    )
    table = Table(HEADS, ranking(study), "Fitness on the scenes of the search; the test on others follows.")
    return [
        Section("Best so far", (table,)),
        Section("The search", (curve,)),
        Section("What it does", _log(study)),
    ]


def _log(study: RunningStudy) -> tuple[Block, ...]:
    return (Code(study.last_line),) if study.last_line else ()
