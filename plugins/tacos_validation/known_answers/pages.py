"""The report of known answers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from tacos_report.page import Block, Page, Paragraph, Section, Table, Warnings
from tacos_validation.known_answers.agreement import PointHeld


def summary(points: Sequence[PointHeld]) -> str:
    """The finding in a sentence, and a line for each point that does not agree."""
    agreed = sum(each.agrees for each in points)
    chance = sum(each.chance for each in points)
    head = f"{agreed} of {len(points)} points agree with the industry ({chance:.1f} by chance)."
    return "\n".join([head, *(_miss(each) for each in points if not each.agrees)])


def _miss(each: PointHeld) -> str:
    if each.probability is None:
        return f"{each.job}, {each.point}: no answer: {each.why}"
    return (
        f"{each.job}, {each.point}: {each.industry}; the study says {_said(each)}, P {each.probability:.2f}"
    )


def page(points: Sequence[PointHeld], not_stated: Mapping[str, Sequence[str]]) -> Page:
    rows = tuple(
        (
            each.job,
            each.point,
            each.industry,
            _said(each),
            "none" if each.probability is None else f"{each.probability:.2f}",
            f"{each.chance:.2f}",
            "yes" if each.agrees else "no",
        )
        for each in points
    )
    heads = ("Job", "Point", "Industry", "Study", "P(industry's class)", "By chance", "Agrees")
    blocks: list[Block] = [
        Table(heads, rows),
        Paragraph(
            "The probability is the share of joint draws of the study's posterior whose best camera is of "
            "the industry's class; by chance, the share of that class among the cameras to choose from."
        ),
    ]
    silent = [f"{job}: {', '.join(names)}" for job, names in not_stated.items()]
    if silent:
        blocks.append(Warnings("Points at which the systems state nothing, or no one thing", tuple(silent)))
    return Page(
        eyebrow="Known answers",
        title=summary(points).split("\n")[0],
        lead="Jobs stated by their physics, studied, and held against what engineers use for them.",
        sections=(Section("Point by point", tuple(blocks)),),
    )


def _said(each: PointHeld) -> str:
    return "none" if each.study is None else str(each.study)
