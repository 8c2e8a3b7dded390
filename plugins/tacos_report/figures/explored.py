"""The design space as far as it was explored: each variable against fitness."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from tacos_report.figures.canvas import NARROW_IN, draw, light_grid
from tacos_report.palette import DOT, RULE, camera_colour
from tacos_report.quantities import quantity, unit_sign, words
from tacos_report.study_data import Tried

_COLUMNS = 3


@dataclass(frozen=True)
class Panel:
    """A variable or derived quantity: its unit, its value for each scored candidate and for the designed
    camera, its bounds."""

    name: str
    unit: str
    values: tuple[float | None, ...]
    designed: float | None = None
    lower: float | None = None
    upper: float | None = None


def explored(panels: Sequence[Panel], scored: Sequence[Tried], *, narrow: bool = False) -> str:
    """SVG of small scatter plots with a shared fitness axis; later candidates are darker.

    `scored`: candidates that have a fitness, at least one; the panels' values are theirs.
    """
    columns = min(1 if narrow else _COLUMNS, len(panels))
    rows = math.ceil(len(panels) / columns)
    names = ", ".join(words(panel.name) for panel in panels)
    description = f"Fitness of {len(scored)} candidates against: {names}."

    def paint(figure: Figure) -> None:
        grid = figure.subplots(rows, columns, sharey=True, squeeze=False)
        for place, axes in enumerate(grid.flat):
            if place >= len(panels):
                axes.set_visible(False)
                continue
            _scatter(axes, panels[place], scored)
            if place % columns == 0:
                axes.set_ylabel("fitness")

    if narrow:
        return draw("explored-narrow", (NARROW_IN, 0.3 + 1.9 * rows), description, paint)
    return draw("explored", (9.2, 0.3 + 2.35 * rows), description, paint)


def _scatter(axes: Axes, panel: Panel, scored: Sequence[Tried]) -> None:
    last = max(candidate.generation for candidate in scored) or 1
    points: dict[int, list[tuple[float, float]]] = {}
    for candidate, x in zip(scored, panel.values, strict=True):
        if x is not None and candidate.fitness is not None:
            points.setdefault(candidate.generation, []).append((x, candidate.fitness))
    for generation, pairs in sorted(points.items()):
        alpha = round(0.22 + 0.6 * generation / last, 3)
        axes.plot(*zip(*pairs, strict=True), "o", color=DOT, alpha=alpha, markersize=5, linestyle="")
    for bound in (panel.lower, panel.upper):
        if bound is not None:
            axes.axvline(bound, color=RULE, linewidth=1.2)
    title = words(panel.name)
    if panel.designed is not None:
        axes.axvline(panel.designed, color=camera_colour(0), linewidth=1.6, zorder=1)
        title += f": {quantity(panel.designed, panel.unit)}"
    axes.set_title(title)
    axes.set_xlabel({"deg": "degrees", "": "value"}.get(panel.unit, unit_sign(panel.unit)))
    axes.xaxis.set_major_locator(MaxNLocator(6))
    axes.margins(x=0.06, y=0.12)
    axes.spines["left"].set_visible(False)
    light_grid(axes, "y")
