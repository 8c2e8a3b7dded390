"""The cameras that are as good as the best, and how far each variable may stray."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial

from tacos_report.analysis import Equivalents
from tacos_report.figures.tolerances import VariableRange, tolerances
from tacos_report.page import Block, Paragraph, Table, in_both_widths
from tacos_report.plain_values import Interval, finite
from tacos_report.quantities import number, quantity, unit_of, words
from tacos_report.sections.ranking import chance
from tacos_report.study_data import StudyData

MORE_LIKELY_THAN_NOT = 0.5
"""Parts of a smaller probability to be as good are named apart: too little was seen of them."""


def blocks(study: StudyData) -> Iterator[Block]:
    found = study.analysis.equivalents
    if found is None or not (found.parts or found.ranges or found.tolerances):
        return
    unsure = [part for part in found.parts if found.probability.get(part, 1.0) < MORE_LIKELY_THAN_NOT]
    yield Paragraph(_parts_words(found, [part for part in found.parts if part not in unsure], study))
    if unsure:
        yield Paragraph(_unsure_words(found, unsure))
    names = list(dict.fromkeys([*found.ranges, *found.tolerances]))
    drawn = [variable for name in names if (variable := _variable(study, found, name)) is not None]
    if drawn:
        yield in_both_widths(
            partial(tolerances, drawn),
            "Grey: the values of cameras within the margin; others differ too. Orange: how far "
            "this one variable may change while all others stay as in the designed camera (the star). Each "
            "row spans the design space.",
        )
    yield Table(
        ("Variable", "Among all that will do", "Tolerance about the designed camera"),
        tuple(
            (
                words(name),
                *(_range_words(study, name, of.get(name)) for of in (found.ranges, found.tolerances)),
            )
            for name in names
        ),
    )


def _parts_words(found: Equivalents, parts: Sequence[str], study: StudyData) -> str:
    margin = f"a margin of {number(found.margin, 2)}" if found.margin else "the margin"
    if not parts:
        return f"Cameras within {margin} of the best lie in these ranges."
    total = len(study.analysis.ranking)
    of = f" of {total}" if total >= len(parts) else ""
    one = len(parts) == 1
    lie = "part lies" if one and not of else "parts lie"
    closing = (
        "No other is as good" if len(found.parts) == 1 else "Choose among them by price, supply and size"
    )
    return f"{len(parts)}{of} {lie} within {margin} of the best: {', '.join(parts)}. {closing}."


def _unsure_words(found: Equivalents, parts: Sequence[str]) -> str:
    named = ", ".join(f"{part} ({chance(found.probability[part])})" for part in parts)
    they_are = "it is" if len(parts) == 1 else "they are"
    few = f"The scenes do not rule out {len(parts)} more"
    return f"{few}; in brackets, the probability that {they_are} as good: {named}."


def _variable(study: StudyData, found: Equivalents, name: str) -> VariableRange | None:
    """A variable of numbers, with the ends of the design space; None for choices."""
    row = next((row for row in study.design_space if row.get("name") == name), {})
    lower, upper = finite(row.get("lower")), finite(row.get("upper"))
    among, about = (_ends(of.get(name)) for of in (found.ranges, found.tolerances))
    if lower is None or upper is None or lower >= upper or (among is None and about is None):
        return None
    chosen = finite(study.designed.camera.get(name)) if study.designed else None
    unit = study.units.get(name) or unit_of(name)
    return VariableRange(words(name), unit, (lower, upper), among, about, chosen)


def _ends(value: Interval | tuple[str, ...] | None) -> Interval | None:
    if value is None or len(value) != 2 or isinstance(value[0], str) or isinstance(value[1], str):
        return None
    return value[0], value[1]


def _range_words(study: StudyData, name: str, value: Interval | tuple[str, ...] | None) -> str:
    ends = _ends(value)
    if ends is None:
        return ", ".join(str(each) for each in value or ())
    unit = study.units.get(name) or unit_of(name)
    return f"{quantity(ends[0], unit)} to {quantity(ends[1], unit)}"
