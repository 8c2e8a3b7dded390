"""Location and causes of the gap: two sections of the report that share the drawings of statistics."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial

from tacos_gap.answer.findings import Cause, Diagnosis
from tacos_gap.report import bars, words
from tacos_gap.report.drawings import Artist, decisive, is_wide, mapped, standing_out
from tacos_gap.report.numbers import Numbers, numbers_of
from tacos_gap.report.overview import overview
from tacos_gap.statistics.views import over
from tacos_report.page import (
    Block,
    Drawing,
    Heading,
    PagePicture,
    Paragraph,
    SideBySide,
    Table,
    in_both_widths,
)

MOST_DRAWINGS = 5
"""Drawings of statistics that are significant, beside the map."""


def where(diagnosis: Diagnosis, numbers: Mapping[str, Numbers], artist: Artist) -> Iterator[Block]:
    if not numbers:
        yield Paragraph("None of the captures could be compared with a simulation.")
        return
    yield in_both_widths(
        partial(overview, numbers, explained=bool(diagnosis.causes)),
        "Each row is one way to compare, in the order of image formation. At 1 the captures are as far from "
        "the simulation as the simulation is from itself; rows of a single number scatter about it.",
    )
    soon = _drawn_with_the_cause(diagnosis)
    found = standing_out(diagnosis, numbers)
    over_image = mapped(found)
    names = [] if over_image is None else [over_image]
    names += [name for name in found if name not in (over_image, soon)]
    wide: list[Drawing] = []
    narrow: list[Drawing] = []
    for place, name in enumerate(names[: MOST_DRAWINGS + 1]):
        drawing = artist.drawing(f"where-{place}", numbers[name])
        (wide if is_wide(numbers[name], compared=bool(diagnosis.causes)) else narrow).append(drawing)
        if name == over_image and name != soon and _is_image(numbers[name]):
            narrow.append(artist.over_radius("where-radius", numbers[name]))
    yield from wide
    yield from _paired(narrow)


def _is_image(numbers: Numbers) -> bool:
    return over(label.at for label in numbers.labels) == "image"


def _drawn_with_the_cause(diagnosis: Diagnosis) -> str | None:
    """Of a single cause the statistic that decided: it follows at once, with the cause."""
    if len(diagnosis.causes) != 1:
        return None
    found = decisive(diagnosis.problem, diagnosis.attribution.best, diagnosis.causes[0].effect)
    return found and found[0]


def _paired(drawings: Sequence[Drawing]) -> Iterator[SideBySide]:
    for start in range(0, len(drawings), 2):
        yield SideBySide(tuple(drawings[start : start + 2]))


def causes(diagnosis: Diagnosis, artist: Artist) -> Iterator[Block]:
    yield in_both_widths(
        partial(bars.certainties, diagnosis),
        "How sure each cause is, from 0 to 1, with the effects that could stand in its place. These are "
        "scores, not probabilities.",
    )
    for cause in diagnosis.causes:
        name = words.effect_words(cause.effect)
        yield Heading(name[:1].upper() + name[1:])
        yield Paragraph(words.cause_sentence(cause))
        wide, narrow = _decided(diagnosis, cause, artist)
        if wide is not None:
            yield wide
        rows = tuple(row for item in cause.parameters.items() for row in words.parameter_rows(*item))
        table = parameter_table(rows)
        beside: list[Drawing | PagePicture | Table] = [narrow] if narrow is not None else []
        if beside or rows:
            yield SideBySide((*beside, *([table] if rows else [])))
        yield Paragraph(cause.evidence)


def parameter_table(rows: Sequence[tuple[str, str, str, str]]) -> Table:
    """Parameters with their intervals; no column of units where none has any."""
    heads = ("parameter", "value", "90 % interval", "unit")
    shown = len(heads) if any(unit for *_, unit in rows) else len(heads) - 1
    return Table(heads[:shown], tuple(row[:shown] for row in rows))


def _decided(diagnosis: Diagnosis, cause: Cause, artist: Artist) -> tuple[Drawing | None, Drawing | None]:
    """The statistic that decided, without this cause and with it: in the whole width, in half of it."""
    best = diagnosis.attribution.best
    found = decisive(diagnosis.problem, best, cause.effect)
    if found is None:
        return None, None
    statistic, without = found
    numbers = numbers_of(diagnosis.problem, without, best.z)[statistic]
    own = replace(artist, before="without it", after="with it")
    name = f"cause-{cause.effect}"
    seen = len(diagnosis.causes) == 1 and mapped([statistic]) is not None  # as the map above
    if _is_image(numbers):
        return (None if seen else own.drawing(name, numbers)), own.over_radius(f"{name}-radius", numbers)
    if is_wide(numbers):
        return (None if seen else own.drawing(name, numbers)), None
    return None, own.drawing(name, numbers)
