"""Sections of the report that tell what a study decided and what its analysis found, one a file.

Each has a function ``blocks(study)``: what it shows, nothing where the result does not have it.
"""

from __future__ import annotations

from tacos_report.page import Section
from tacos_report.sections import decision, equivalents, front, importance, purchase, ranking, scenarios
from tacos_report.study_data import StudyData

_ANSWERS = (
    ("How sure is that?", decision),
    ("What to buy", purchase),
    ("All parts, ranked", ranking),
    ("Any of these will do", equivalents),
    ("What matters, and how much", importance),
    ("More than one aim", front),
)


def answers(study: StudyData) -> list[Section]:
    """What to do and how sure that is: before any detail of the cameras."""
    found = (Section(title, tuple(section.blocks(study))) for title, section in _ANSWERS)
    return [section for section in found if section.blocks]


def cautions(study: StudyData) -> list[str]:
    """What to know before all else: notes that stand with no part to buy, and why there was no test."""
    of_parts = purchase.doubts(study)
    found = [note for note in study.notes if note not in of_parts]
    if (stopped := study.result.get("stopped")) and not study.tested:
        found.append(f"The search ended: {stopped}")
    return found


def by_scenario(study: StudyData) -> list[Section]:
    """The scores of each scenario by itself, where there are several."""
    blocks = tuple(scenarios.blocks(study))
    return [Section("Scenario by scenario", blocks)] if blocks else []
