"""Course of the search, and the places it looked at in the design space."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial

from tacos_report import story
from tacos_report.figures.catalog_choices import catalog_choices
from tacos_report.figures.explored import Panel, explored
from tacos_report.figures.search_curve import search_curve
from tacos_report.page import Block, Heading, Paragraph, in_both_widths
from tacos_report.plain_values import finite
from tacos_report.quantities import unit_of, words
from tacos_report.study_data import StudyData, Tried, parts_of


def course(study: StudyData) -> Iterator[Block]:
    stopped = study.result.get("stopped")
    yield Paragraph(f"{story.search_words(study)}{f' It ended: {stopped}.' if stopped else ''}")
    if study.scored:
        yield in_both_widths(
            partial(search_curve, study.generations, study.shows_design),
            f"Every candidate is a dot, in the order of the search. {story.chosen_words(study)} The "
            "fitness here is on the scenes the camera was designed on, so it need not equal the one on "
            "unseen scenes.",
        )


def space(study: StudyData) -> Iterator[Block]:
    if study.design_space:
        rows = (f"{words(row['name'])}: {story.space_words(row)}" for row in study.design_space)
        yield Paragraph(f"{'; '.join(rows)}.")
    scored = study.scored
    if not scored:
        yield Paragraph("No candidate was scored, so there is nothing to plot.")
        return
    if panels := _panels(study, scored):
        yield in_both_widths(
            partial(explored, panels, scored),
            "Every scored candidate; later ones are darker. The orange line is the designed camera, grey "
            "ones are the bounds of the design space. An orange line on a bound says that a wider space may "
            "hold a better camera.",
        )
    designed = parts_of(study.designed.camera) if study.designed else {}
    for name in parts_of(scored[0].camera):
        yield Heading(f"{words(name)}: the best that were tried")
        yield in_both_widths(
            partial(catalog_choices, name, scored, designed.get(name)),
            "Every candidate with that part is a dot. Dots of one row differ in the other variables. "
            "Orange is the part of the designed camera, where it was tried.",
        )


def _panels(study: StudyData, scored: Sequence[Tried]) -> list[Panel]:
    """One panel per numeric variable, within its bounds, then one per derived quantity."""
    bounds = {row["name"]: (row.get("lower"), row.get("upper")) for row in study.design_space}
    numeric = [name for name, value in scored[0].camera.items() if isinstance(value, int | float)]
    designed = {**study.designed.derived, **study.designed.camera} if study.designed else {}
    panels = []
    for name in dict.fromkeys([*numeric, *scored[0].derived]):
        values = tuple(tried.camera.get(name, tried.derived.get(name)) for tried in scored)
        unit = study.units.get(name) or unit_of(name)
        panels.append(Panel(name, unit, values, finite(designed.get(name)), *bounds.get(name, (None, None))))
    return panels
