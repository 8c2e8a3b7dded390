"""Time of a study by its parts."""

from __future__ import annotations

from collections.abc import Mapping

from matplotlib.figure import Figure

from tacos_report.figures.canvas import draw
from tacos_report.palette import DOT, INK, MUTED
from tacos_report.quantities import duration, number, words


def time_spent(seconds_by_node: Mapping[str, float]) -> str:
    """SVG of one bar per node, the longest first, with its seconds and its share of all."""
    rows = sorted(seconds_by_node.items(), key=lambda pair: -pair[1])
    total = sum(seconds_by_node.values()) or 1.0
    longest = max([value for _, value in rows], default=1.0) or 1.0
    parts = ", ".join(f"{words(name)} {duration(seconds)}" for name, seconds in rows)

    def paint(figure: Figure) -> None:
        axes = figure.add_subplot()
        for place, (_, seconds) in enumerate(rows):
            axes.barh(place, seconds, height=0.62, color=DOT, alpha=0.85)
            text = f"{duration(seconds)}  ({number(100 * seconds / total, 2)} %)"
            axes.text(seconds + 0.012 * longest, place, text, va="center", color=INK)
        axes.set_yticks(range(len(rows)), [words(name) for name, _ in rows])
        axes.tick_params(axis="y", length=0, labelcolor=INK)
        axes.invert_yaxis()
        axes.set_xlim(0, longest * 1.35)
        axes.set_xticks([])
        axes.spines[:].set_visible(False)
        axes.set_xlabel("seconds, summed over all workers", color=MUTED, loc="left")

    return draw("time-spent", (6.4, 0.5 + 0.3 * len(rows)), f"Time by part: {parts}.", paint)
