"""Figures of a diagnosis with matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tacos_report.palette import MUTED, camera_colour

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from tacos_gap.report.result_tables import DiagnosisResult


def closure(result: DiagnosisResult, *, axes: Axes | None = None) -> Axes:
    """A waterfall from the whole gap (1) down to what remains: each cause takes its Shapley share of it."""
    if axes is None:
        from matplotlib import pyplot

        axes = pyplot.subplots(layout="constrained")[1]
    left = 1.0
    names = ["gap", *(cause["effect"] for cause in result.data["causes"]), "unexplained"]
    axes.bar(0, 1.0, color=MUTED)
    for place, cause in enumerate(result.data["causes"], start=1):
        axes.bar(place, -cause["shapley"], bottom=left, color=camera_colour(0))
        left -= cause["shapley"]
    axes.bar(len(names) - 1, left, color=MUTED)
    axes.set_xticks(range(len(names)), names, rotation=30, ha="right")
    axes.set_ylabel("share of the squared gap above the noise floor")
    return axes
