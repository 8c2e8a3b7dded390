"""Cameras of which none is better in one aim without being worse in another."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from tacos_report.analysis import FrontPoint, Objective
from tacos_report.figures.trade_offs import trade_offs
from tacos_report.page import Block, Detailed, Table, in_both_widths
from tacos_report.prices import price_words
from tacos_report.quantities import number, quantity, words
from tacos_report.story import optics_words
from tacos_report.study_data import StudyData


def blocks(study: StudyData) -> Iterator[Block]:
    objectives, points = study.analysis.objectives, study.analysis.front
    if not objectives or not points:
        return
    drawn = [
        each for each in objectives if each.name != "fitness" and any(each.name in p.values for p in points)
    ]
    if drawn:
        yield in_both_widths(
            partial(trade_offs, drawn, points, study.designed.camera if study.designed else None),
            "Cameras that no other beats in all aims. Filled: rendered on fresh scenes. Hollow: predicted by "
            "the surrogate. Bars: 95 % intervals. Orange: the designed camera, if it is on the front. "
            "Arrows point to better values.",
        )
    shown_first = sorted(points, key=lambda point: -point.fitness)
    yield Table(
        ("Camera", "Fitness (95 %)", *(_head(each) for each in drawn)),
        tuple(_row(point, drawn, study) for point in shown_first),
    )


def _head(objective: Objective) -> str:
    return f"{words(objective.name)} ({'less' if objective.aim == 'min' else 'more'} is better)"


def _row(point: FrontPoint, objectives: list[Objective], study: StudyData) -> tuple[str | Detailed, ...]:
    optics = "; ".join(filter(None, (optics_words(point.camera, study.units), price_words(point.camera))))
    ends = f"{number(point.ci[0])} to {number(point.ci[1])}" if point.ci else ""
    values = (
        quantity(point.values[each.name], each.unit) if each.name in point.values else "not stated"
        for each in objectives
    )
    return (Detailed(point.part or "camera", optics), Detailed(number(point.fitness), ends), *values)
