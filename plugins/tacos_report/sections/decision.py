"""The designed camera against every product: differences with intervals, and verdicts."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from tacos_report import verdicts
from tacos_report.figures.forest import forest
from tacos_report.page import Block, Paragraph, Table, in_both_widths
from tacos_report.study_data import StudyData


def blocks(study: StudyData) -> Iterator[Block]:
    analysis = study.analysis
    if analysis.degenerate:
        yield Paragraph(analysis.degenerate)
    elif analysis.decision is None and analysis.decision_absent:
        yield Paragraph(analysis.decision_absent)
    if not analysis.comparisons:
        return
    margin = analysis.decision.margin if analysis.decision else 0.0
    drawn = [each for each in analysis.comparisons if each.interval is not None]
    if drawn:
        names = [camera.name for camera in study.cameras]
        titles = {each.against: study.title_of(each.against) for each in drawn}
        indices = {name: names.index(name) for name in titles if name in names}
        yield in_both_widths(
            partial(forest, drawn, titles, indices, margin),
            "Fitness of the designed camera less that of each product, over the same unseen scenes: to the "
            "right of zero the designed camera is better. Intervals are corrected for interim analyses."
            + (" Differences within the shaded margin are negligible." if margin else ""),
        )
    yield Table(
        ("Against", "Difference in fitness", "Verdict", "Test scenes"),
        tuple(
            (study.title_of(each.against), *verdicts.row(each), str(each.episodes) if each.episodes else "")
            for each in analysis.comparisons
        ),
    )
