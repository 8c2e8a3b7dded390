"""Every part that can be had, at its own best optics."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial

from tacos_report.analysis import RankedPart
from tacos_report.figures.parts_ranked import parts_ranked
from tacos_report.page import Block, Detailed, Folded, Paragraph, Table, in_both_widths
from tacos_report.prices import price_words
from tacos_report.quantities import number, words
from tacos_report.sections import part_details
from tacos_report.story import optics_words
from tacos_report.study_data import StudyData

_SHOWN = 3
"""Rows of the table until all are asked for: the drawing has them all, and a phone shows a row a screen."""


def blocks(study: StudyData) -> Iterator[Block]:
    ranked = study.analysis.ranking
    if ranked:
        carried = products_of_parts(study)
        designed = [part.part for part in ranked if study.has_parts_of_design(part)]
        yield in_both_widths(
            partial(parts_ranked, ranked, carried, designed),
            "Each part with its best optics. Filled: rendered; large: again on fresh scenes. Hollow: "
            "predicted by the surrogate, never rendered. Bars: 95 % credible intervals; grey band: that of "
            "the first part. Orange: the part of the designed camera, chosen on scenes and not by this "
            "list. Coloured diamond: the part of a product.",
        )
        better = [f"P(better than {study.title_of(name)})" for name in _products(study)]
        heads = ("", "Part", "Its best optics", "Fitness (95 %)", *better, "Known from")
        rows = tuple(_row(place, part, study, carried) for place, part in enumerate(ranked, start=1))
        kept = tuple(i for i, part in enumerate(ranked) if part.part in designed and i >= _SHOWN)
        yield Table(heads, rows, first=_SHOWN, kept=kept)
        yield Folded(
            "Each part: its best cameras, their scores and frames", tuple(part_details.blocks(study))
        )
    if left_out := study.analysis.left_out:
        if ranked:
            yield Paragraph(f"{len(left_out)} more cannot be used:")
        alike: dict[str, list[str]] = {}
        for part, why in left_out.items():
            alike.setdefault(why, []).append(part)
        rows = tuple((", ".join(parts), why) for why, parts in alike.items())
        yield Table(("Parts", "Why they cannot be used"), rows)


def products_of_parts(study: StudyData) -> dict[str, tuple[int, str]]:
    """Parts, and products as parts of themselves, with the place and the title of the product."""
    found: dict[str, tuple[int, str]] = {}
    for index, camera in enumerate(study.cameras):
        if camera in study.others:
            parts = [value.get("name") for value in camera.camera.values() if isinstance(value, Mapping)]
            for name in (*parts, camera.name, camera.title):
                if isinstance(name, str):
                    found.setdefault(name, (index, camera.title))
    return found


def chance(probability: float) -> str:
    """A probability as people say it.

    >>> chance(0.873), chance(0.9999), chance(0.0)
    ('87\\u202f%', '> 99\\u202f%', '< 1\\u202f%')
    """
    share = round(100 * probability)
    return "> 99\u202f%" if share > 99 else "< 1\u202f%" if share < 1 else f"{share}\u202f%"


def _products(study: StudyData) -> list[str]:
    return list(dict.fromkeys(name for part in study.analysis.ranking for name in part.p_better))


def _row(
    place: int, part: RankedPart, study: StudyData, carried: Mapping[str, tuple[int, str]]
) -> tuple[str | Detailed, ...]:
    ends = f"{number(part.ci[0])} to {number(part.ci[1])}" if part.ci else ""
    chances = (part.p_better.get(name) for name in _products(study))
    title = carried[part.part][1] if part.part in carried else ""
    return (
        str(place),
        Detailed(
            part.part,
            f"in the {title}" if title and title != part.part else "",
            anchor=part_details.anchor(place),
        ),
        Detailed(optics_words(part.camera, study.units), price_words(part.camera)),
        Detailed(number(part.fitness), ends),
        *("" if value is None else chance(value) for value in chances),
        Detailed(
            _known_from(part),
            f"not stated: {', '.join(words(name).lower() for name in part.unknown)}" if part.unknown else "",
        ),
    )


def _known_from(part: RankedPart) -> str:
    if not part.episodes:
        return "the model alone"
    return (
        f"{part.episodes} scene{'' if part.episodes == 1 else 's'}{', scored again' if part.rescored else ''}"
    )
