"""Tolerance of each variable: ranges within the bounds of the design space."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from matplotlib.figure import Figure

from tacos_report.figures.canvas import NARROW_IN, draw
from tacos_report.palette import DOT, INK, MUTED, RULE, camera_colour
from tacos_report.quantities import quantity

Ends = tuple[float, float]


@dataclass(frozen=True)
class VariableRange:
    """A variable in words, its bounds, and where in them equally good cameras lie."""

    title: str
    unit: str
    bounds: Ends
    among: Ends | None
    about: Ends | None
    chosen: float | None


def tolerances(variables: Sequence[VariableRange], *, narrow: bool = False) -> str:
    """SVG of one bar per variable, each over its own bounds."""
    said = "; ".join(
        f"{v.title} {quantity(v.about[0], v.unit)} to {quantity(v.about[1], v.unit)}"
        for v in variables
        if v.about
    )

    def paint(figure: Figure) -> None:
        axes = figure.add_subplot()
        for place, variable in enumerate(variables):
            low, high = variable.bounds
            axes.plot([0, 1], [place, place], color=RULE, linewidth=2, solid_capstyle="butt", zorder=0)
            for ends, colour, alpha in ((variable.among, DOT, 0.4), (variable.about, camera_colour(0), 0.85)):
                if ends is not None:
                    at = [(end - low) / (high - low) for end in ends]
                    axes.plot(at, [place, place], color=colour, linewidth=11, alpha=alpha,
                              solid_capstyle="butt", zorder=1)  # fmt: skip
            if variable.chosen is not None:
                at_chosen = (variable.chosen - low) / (high - low)
                axes.plot([at_chosen], [place], "*", color=INK, markersize=11, linestyle="", zorder=3)
            for at_end, end, side in ((0.0, low, "right"), (1.0, high, "left")):
                gap = -6 if side == "right" else 6
                axes.annotate(quantity(end, variable.unit), (at_end, place), (gap, 0), ha=side, va="center",
                              textcoords="offset points", color=MUTED, fontsize=8)  # fmt: skip
            axes.text(0, place - 0.36, variable.title, color=INK, fontsize=9.5, va="center")
        beside = 0.24 if narrow else 0.09  # room for the ends of the ranges
        axes.set_xlim(-beside, 1 + beside)
        axes.set_ylim(len(variables) - 0.55, -0.65)
        axes.axis("off")

    name, width_in = ("tolerances-narrow", NARROW_IN) if narrow else ("tolerances", 9.2)
    return draw(name, (width_in, 0.25 + 0.62 * len(variables)), f"Tolerances: {said}.", paint)
