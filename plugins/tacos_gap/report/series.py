"""The three things every drawing compares, each with one look throughout the page."""

from __future__ import annotations

from typing import Any

from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from tacos_report.palette import INK, MUTED, PAPER, RULE, camera_colour

REAL, BEFORE, AFTER = INK, camera_colour(0), camera_colour(1)

REAL_DOTS: dict[str, Any] = {
    "color": REAL,
    "marker": "o",
    "markersize": 4.5,
    "linestyle": "",
    "markeredgecolor": PAPER,
    "markeredgewidth": 0.5,
}
BEFORE_LINE: dict[str, Any] = {"color": BEFORE, "linewidth": 1.8, "marker": "s", "markersize": 3.6}
AFTER_LINE: dict[str, Any] = {"color": AFTER, "linewidth": 1.8, "marker": "D", "markersize": 3.6}
BAND: dict[str, Any] = {"color": RULE, "alpha": 0.75, "linewidth": 0}


def legend(figure: Figure, before: str, after: str | None) -> None:
    """Legend above the drawing; `after` is None where nothing was added."""
    handles = [Line2D([], [], **{"markeredgewidth": 0.5, **REAL_DOTS})]
    names = ["real"]
    handles.append(Line2D([], [], **BEFORE_LINE))
    names.append(before)
    if after is not None:
        handles.append(Line2D([], [], **AFTER_LINE))
        names.append(after)
    handles.append(Line2D([], [], color=RULE, linewidth=7, alpha=0.75))
    names.append("noise floor")
    figure.legend(
        handles, names, loc="outside upper left", ncols=4, labelcolor=MUTED, fontsize=8.5, columnspacing=1.2
    )
