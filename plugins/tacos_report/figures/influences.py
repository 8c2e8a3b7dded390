"""Importance of variables, and one small picture for each."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from tacos_report.analysis import Influence
from tacos_report.figures.canvas import NARROW_IN, draw, light_grid
from tacos_report.palette import DOT, INK, TERMS, camera_colour
from tacos_report.plain_values import finite
from tacos_report.quantities import number, unit_sign, words

_COLUMNS = 3
_NAMED = 6
"""Parts named under a curve over parts: more would not be readable."""


def shares(influences: Sequence[Influence], *, narrow: bool = False) -> str:
    """SVG of the total and first-order indices, one bar per variable."""
    said = ", ".join(f"{words(each.variable)} {number(each.total, 2)}" for each in influences)

    def paint(figure: Figure) -> None:
        axes = figure.add_subplot()
        for place, each in enumerate(influences):
            total = max(each.total, 0.0)
            axes.barh(place, total, height=0.56, color=TERMS[2])
            axes.barh(place, min(max(each.first_order or 0.0, 0.0), total), height=0.56, color=TERMS[0])
            axes.annotate(f"{100 * total:.0f} %", (total, place), (6, 0), textcoords="offset points",
                          va="center", color=INK)  # fmt: skip
        axes.set_yticks(range(len(influences)), [words(each.variable) for each in influences])
        axes.tick_params(axis="y", length=0, labelcolor=INK)
        axes.set_ylim(len(influences) - 0.5, -0.5)
        axes.set_xlim(0, max([1.0, *(each.total for each in influences)]) * (1.15 if narrow else 1.08))
        axes.set_xticks([])
        axes.spines[:].set_visible(False)

    name, width_in = ("importance-narrow", NARROW_IN) if narrow else ("importance", 9.2)
    return draw(name, (width_in, 0.3 + 0.34 * len(influences)), f"Importance: {said}.", paint)


def curves(influences: Sequence[Influence], chosen: Mapping[str, Any], *, narrow: bool = False) -> str:
    """SVG of the fitness along each variable with its band, at least two points each.

    `chosen`: the designed camera's variables.
    """
    columns = min(1 if narrow else _COLUMNS, len(influences))
    rows = math.ceil(len(influences) / columns)
    names = ", ".join(words(each.variable) for each in influences)

    def paint(figure: Figure) -> None:
        grid = figure.subplots(rows, columns, sharey=True, squeeze=False)
        for place, axes in enumerate(grid.flat):
            if place >= len(influences):
                axes.set_visible(False)
                continue
            each = influences[place]
            (_along_parts if isinstance(each.curve[0].value, str) else _along)(axes, each, chosen)
            axes.set_title(words(each.variable))
            axes.spines["left"].set_visible(False)
            light_grid(axes, "y")
            if place % columns == 0:
                axes.set_ylabel("fitness")

    if narrow:
        size_in = (NARROW_IN, 0.3 + 1.9 * rows)
        return draw("importance-curves-narrow", size_in, f"Fitness along: {names}.", paint)
    return draw("importance-curves", (9.2, 0.3 + 2.35 * rows), f"Fitness along: {names}.", paint)


def _along(axes: Axes, influence: Influence, chosen: Mapping[str, Any]) -> None:
    points = sorted((p.value, p.mean, p.low, p.high) for p in influence.curve if isinstance(p.value, float))
    at, mean, low, high = zip(*points, strict=True)
    axes.fill_between(at, low, high, color=DOT, alpha=0.25, linewidth=0)
    axes.plot(at, mean, color=INK, linewidth=1.6)
    if (value := finite(chosen.get(influence.variable))) is not None:
        axes.axvline(value, color=camera_colour(0), linewidth=1.6)
    axes.set_xlabel({"deg": "degrees"}.get(influence.unit, unit_sign(influence.unit)))
    axes.xaxis.set_major_locator(MaxNLocator(5))
    axes.margins(x=0.03, y=0.1)


def _along_parts(axes: Axes, influence: Influence, chosen: Mapping[str, Any]) -> None:
    points = sorted(influence.curve, key=lambda point: -point.mean)
    row = chosen.get(influence.variable)
    name = row.get("name") if isinstance(row, Mapping) else row
    for colour, own in ((DOT, False), (camera_colour(0), True)):
        placed = [
            (i, each.mean, each.low, each.high)
            for i, each in enumerate(points)
            if own == (each.value == name)
        ]
        if placed:
            places, mean, low, high = zip(*placed, strict=True)
            axes.vlines(
                places, low, high, color=colour, linewidth=1.6, alpha=0.7, capstyle="projecting", zorder=2
            )
            axes.plot(places, mean, "o", color=colour, markersize=4, linestyle="")
    if len(points) <= _NAMED:
        axes.set_xticks(range(len(points)), [str(point.value) for point in points], rotation=30, ha="right")
    else:
        axes.set_xticks([])
        axes.set_xlabel(f"{len(points)} choices, best first")
    axes.margins(x=0.05, y=0.1)
