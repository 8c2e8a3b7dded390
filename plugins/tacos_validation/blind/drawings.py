"""Curves of the report of a blind check."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Canvas

from tacos_report.figures.canvas import NARROW_IN, draw, light_grid
from tacos_report.page import Drawing, in_both_widths
from tacos_report.palette import MUTED, camera_colour
from tacos_validation.blind.calibration import (
    Stated,
    compared,
    completenesses,
    coverage,
    expected_calibration_error,
    presences,
    reliability,
)
from tacos_validation.blind.cases import Case
from tacos_validation.blind.figure import Figure
from tacos_validation.blind.scoring import ladder


def severities(cases: Sequence[Case]) -> Drawing:
    return in_both_widths(
        partial(_severities, ladder(cases)), "T1 with charts. Dashed: the goal from 4 units on."
    )


def _severities(steps: Sequence[tuple[float, Figure]], *, narrow: bool = False) -> str:
    def paint(figure: Canvas) -> None:
        axes = figure.add_subplot()
        at = [severity for severity, _ in steps]
        values = np.array([each.value for _, each in steps])
        ends = np.array([[each.low, each.high] for _, each in steps]).T
        axes.errorbar(
            at, values, yerr=np.abs(ends - values), color=camera_colour(1), marker="o", capsize=3, linewidth=2
        )
        axes.axhline(0.95, color=MUTED, linewidth=1, linestyle="--")
        axes.set_xscale("log", base=2)
        axes.set_xticks(at, [f"{value:g}" for value in at])
        axes.set_ylim(0, 1.02)
        axes.set_xlabel("severity [noise floor]")
        axes.set_ylabel("first cause right")
        light_grid(axes, "y")

    described = "Share of cases with the right first cause against the severity of the withheld effect."
    if narrow:
        return draw("ladder-narrow", (NARROW_IN, 3.0), described, paint)
    return draw("ladder", (7.0, 3.2), described, paint)


def reliability_diagrams(cases: Sequence[Case]) -> list[Drawing]:
    """Stated certainty against the share of right answers: of effects, and of answers as a whole."""
    return [
        _reliability(name, words, stated)
        for name, words, stated in (
            (
                "present",
                "Named effects by the presence stated: how often each was there.",
                presences(cases),
            ),
            (
                "complete",
                "Answers by the completeness stated: how often nothing was left out.",
                completenesses(cases),
            ),
        )
        if stated
    ]


def _reliability(name: str, words: str, stated: Sequence[Stated]) -> Drawing:
    bins = reliability(stated)

    def paint(figure: Canvas) -> None:
        axes = figure.add_subplot()
        _diagonal(axes)
        _points(
            axes,
            [each.stated for each in bins],
            [each.true for each in bins],
            [(each.low, each.high) for each in bins],
        )
        for each in bins:
            axes.annotate(
                str(each.count), (each.stated, each.true), (5, -9), textcoords="offset points",
                fontsize=7, color=MUTED,
            )  # fmt: skip
        axes.set_xlabel("stated")
        axes.set_ylabel("true")

    caption = f"{words} Numbers are counts; error {expected_calibration_error(stated):.1%}, of {len(stated)}."
    return Drawing(draw(f"reliability-{name}", (4.2, 3.6), words, paint), caption)


def interval_coverage(cases: Sequence[Case]) -> Drawing | None:
    """Coverage of parameter intervals, scaled to other levels than their 90 %."""
    measured = coverage(compared(cases, "T1", "T4", "T7"))
    if not measured:
        return None

    def paint(figure: Canvas) -> None:
        axes = figure.add_subplot()
        _diagonal(axes)
        _points(
            axes,
            [level for level, _ in measured],
            [each.value for _, each in measured],
            [(each.low, each.high) for _, each in measured],
        )
        axes.set_xlim(0.4, 1.02)
        axes.set_ylim(0, 1.05)
        axes.set_xlabel("nominal coverage")
        axes.set_ylabel("intervals that hold the truth")

    words = "Share of parameter intervals that hold the truth, against their nominal coverage."
    caption = f"Intervals of {measured[0][1].count} parameters, those of 90 % scaled as a Gaussian's."
    return Drawing(draw("coverage", (4.2, 3.6), words, paint), caption)


def _diagonal(axes: Axes) -> None:
    axes.plot([0, 1], [0, 1], color=MUTED, linewidth=1, linestyle="--")
    axes.set_xlim(0, 1.02)
    axes.set_ylim(0, 1.05)
    light_grid(axes, "y")


def _points(
    axes: Axes, at: Sequence[float], values: Sequence[float], ends: Sequence[tuple[float, float]]
) -> None:
    reach = np.abs(np.array(ends) - np.array(values)[:, None]).T
    axes.errorbar(at, values, yerr=reach, color=camera_colour(1), marker="o", capsize=3, linewidth=2)
