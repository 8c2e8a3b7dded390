"""Sections of the report of a study, one a file.

Each has a function ``blocks(study)``: what it shows, nothing where the result does not have it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from tacos_report.page import Block, Section
from tacos_report.sections import (
    cameras,
    decision,
    equivalents,
    front,
    importance,
    moments,
    purchase,
    ranking,
    run,
    scenarios,
    search,
    views,
)
from tacos_report.story import failure_groups
from tacos_report.study_data import StudyData


def of_study(study: StudyData) -> list[Section]:
    """Sections in order: the advice and its certainty, the cameras, the search; no empty ones."""
    found = (Section(title, tuple(blocks)) for title, blocks in _titled(study))
    return [section for section in found if section.blocks]


def _titled(study: StudyData) -> Iterator[tuple[str, Iterable[Block]]]:
    yield "How sure is that?", decision.blocks(study)
    yield "What to buy", purchase.blocks(study)
    yield "All parts, ranked", ranking.blocks(study)
    yield "Any of these will do", equivalents.blocks(study)
    yield "What matters, and how much", importance.blocks(study)
    yield "More than one aim", front.blocks(study)
    yield "The same moments through each camera", moments.blocks(study)
    yield "What each camera sees", views.blocks(study)
    yield cameras.title(study), cameras.blocks(study)
    yield "Scenario by scenario", scenarios.blocks(study)
    yield "The search", search.course(study)
    yield "The design space explored", search.space(study)
    failed = failure_groups(study.tried)
    yield f"Where the time went{', and what failed' if failed else ''}", run.costs(study)
    yield "Repeat this run", run.repeat(study)


def cautions(study: StudyData) -> list[str]:
    """Notes that come first: those without a part to buy, and the reason for a missing test."""
    of_parts = purchase.doubts(study)
    found = [note for note in study.notes if note not in of_parts]
    if (stopped := study.result.get("stopped")) and not study.tested:
        found.append(f"The search ended: {stopped}")
    if reality := study.result.get("reality"):
        found.append(str(reality))
    return found
