"""Importance of each variable, and the fitness along it."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from tacos_report.figures.influences import curves, shares
from tacos_report.page import Block, in_both_widths
from tacos_report.study_data import StudyData


def blocks(study: StudyData) -> Iterator[Block]:
    found = study.analysis.influences
    if not found:
        return
    yield in_both_widths(
        partial(shares, found),
        "How much of the variance of the fitness a variable explains (Sobol indices): dark by "
        "itself, light together with other variables. A long light part means that the variable has to be "
        "chosen together with others.",
    )
    drawn = [influence for influence in found if len(influence.curve) > 1]
    if drawn:
        chosen = study.designed.camera if study.designed else {}
        yield in_both_widths(
            partial(curves, drawn, chosen),
            "Fitness along each variable, with all others at their best; the band is the 95 % credible "
            "interval. The upright line is the designed camera.",
        )
