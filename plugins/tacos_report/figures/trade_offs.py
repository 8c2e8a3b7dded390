"""A front: each aim against the fitness."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from tacos_report.analysis import FrontPoint, Objective
from tacos_report.figures.canvas import NARROW_IN, draw, light_grid
from tacos_report.palette import DOT, INK, PAPER, camera_colour
from tacos_report.quantities import unit_sign, words

_COLUMNS = 2
_NAMED = 12


def trade_offs(
    objectives: Sequence[Objective],
    points: Sequence[FrontPoint],
    designed: Mapping[str, Any] | None,
    *,
    narrow: bool = False,
) -> str:
    """SVG of one panel per objective, the fitness upwards in all of them.

    `designed`: the designed camera's variables, which may be those of a point.
    """
    columns = min(1 if narrow else _COLUMNS, len(objectives))
    rows = math.ceil(len(objectives) / columns)
    names = ", ".join(words(each.name) for each in objectives)

    def paint(figure: Figure) -> None:
        grid = figure.subplots(rows, columns, sharey=True, squeeze=False)
        for place, axes in enumerate(grid.flat):
            if place >= len(objectives):
                axes.set_visible(False)
                continue
            _panel(axes, objectives[place], points, designed)
            if place % columns == 0:
                axes.set_ylabel("fitness")

    said = f"{len(points)} cameras of a front: fitness against {names}."
    if narrow:
        return draw("front-narrow", (NARROW_IN, 0.3 + 2.8 * rows), said, paint)
    return draw("front", (9.2, 0.3 + 3.4 * rows), said, paint)


def _panel(
    axes: Axes, objective: Objective, points: Sequence[FrontPoint], designed: Mapping[str, Any] | None
) -> None:
    here = [(point.values[objective.name], point) for point in points if objective.name in point.values]
    for x, point in here:
        colour = camera_colour(0) if point.camera == designed else DOT
        if point.ci is not None:
            axes.plot([x, x], point.ci, color=colour, linewidth=1.2, alpha=0.6)
        axes.plot([x], [point.fitness], "o", markersize=6.5, linestyle="", zorder=2, markeredgewidth=1.3,
                  color=colour if point.rescored else PAPER, markeredgecolor=colour)  # fmt: skip
        if len(here) <= _NAMED and point.part:
            axes.annotate(
                point.part, (x, point.fitness), (6, 5), textcoords="offset points", color=INK, fontsize=8
            )
    unit = f" [{unit_sign(objective.unit)}]" if unit_sign(objective.unit) else ""
    arrow = "← better" if objective.aim == "min" else "better →"
    axes.set_xlabel(f"{words(objective.name)}{unit}   {arrow}")
    axes.xaxis.set_major_locator(MaxNLocator(6))
    axes.margins(x=0.14, y=0.12)
    axes.spines["left"].set_visible(False)
    light_grid(axes, "y")
