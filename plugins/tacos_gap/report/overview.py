"""Every statistic in one drawing: how far apart before, how far after, and the noise floor."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from tacos_framework import STAGES
from tacos_gap.report.numbers import Numbers
from tacos_gap.report.series import AFTER, BEFORE
from tacos_gap.statistics.views import view_of
from tacos_report.figures.canvas import NARROW_IN, draw, light_grid, name_rows
from tacos_report.palette import INK, MUTED, RULE
from tacos_report.quantities import number

MOST = 14
_STAND_OUT = 1.3


def overview(numbers: Mapping[str, Numbers], *, explained: bool, narrow: bool = False) -> str:
    """SVG of a line per statistic from its gap before to its gap after; the largest `MOST` of them.

    `explained`: true if anything was added; else only what was before is drawn. `narrow`: for the width of a
    phone: what is compared stands above its line.
    """
    rows = _rows(list(numbers.values()))
    top = max((row.gap_before for row in rows), default=1.0)
    said = ", ".join(f"{view_of(row.statistic).title} {number(row.gap_before, 2)}" for row in rows[:4])

    def paint(figure: Figure) -> None:
        axes = figure.add_subplot()
        axes.axvspan(0.01, 1.0, color=RULE, alpha=0.45, linewidth=0)
        for place, row in enumerate(rows):
            if explained:
                axes.plot([row.gap_after, row.gap_before], [place, place], color=RULE, linewidth=2.5)
                axes.plot([row.gap_after], [place], "D", color=AFTER, markersize=6)
            axes.plot([row.gap_before], [place], "s", color=BEFORE, markersize=7)
            axes.annotate(
                number(row.gap_before, 2), (max(row.gap_before, row.gap_after), place), (9, 0),
                textcoords="offset points", va="center", color=MUTED, fontsize=8.5,
            )  # fmt: skip
        labels = name_rows(axes, [view_of(row.statistic).title for row in rows], narrow=narrow)
        for label, row in zip(labels, rows, strict=True):
            label.set(color=INK if row.gap_before > _STAND_OUT else MUTED, fontsize=9.5)
        axes.set_ylim(len(rows) - 0.3, -1.0 if narrow else -0.6)
        axes.set_xscale("log")
        low = min(min(row.gap_after, row.gap_before) for row in rows) if rows else 1.0
        axes.set_xlim(min(0.6, max(low, 0.05) * 0.85), max(top, 2.0) * 1.5)
        ticks = [t for t in (0.1, 0.3, 1, 3, 10, 30, 100, 300) if axes.get_xlim()[0] <= t < top * 1.5]
        axes.set_xticks(ticks, [f"{t:g}" for t in ticks])
        axes.minorticks_off()
        between = "\n" if narrow else " "
        axes.set_xlabel(f"difference between real and simulated,{between}in units of the noise floor")
        axes.text(0.97, len(rows) - 0.5, "noise floor", color=MUTED, ha="right", va="center", fontsize=8.5)
        axes.spines[["left", "bottom"]].set_visible(False)
        light_grid(axes, "x")
        handles = [Line2D([], [], color=BEFORE, marker="s", linestyle="", markersize=7)]
        names = ["simulation as it was"]
        if explained:
            handles.append(Line2D([], [], color=AFTER, marker="D", linestyle="", markersize=6))
            names.append("with the causes added, on what they were not fitted to")
        figure.legend(handles, names, loc="outside upper left", ncols=1 if narrow else 2, labelcolor=MUTED)

    if narrow:
        return draw(
            "overview-narrow", (NARROW_IN, 1.35 + 0.4 * len(rows)), f"Gap by statistic: {said}.", paint
        )
    return draw("overview", (9.2, 1.0 + 0.27 * len(rows)), f"Gap by statistic: {said}.", paint)


def _rows(numbers: Sequence[Numbers]) -> list[Numbers]:
    largest = sorted(numbers, key=lambda n: -max(n.gap_before, n.gap_after))[:MOST]
    order: dict[str, int] = {stage: place for place, stage in enumerate(STAGES)}
    return sorted(largest, key=lambda n: (order.get(n.stage, 99), -n.gap_before))
