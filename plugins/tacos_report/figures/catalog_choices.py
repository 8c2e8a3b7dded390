"""Rows of a catalog that were tried: the best of them by name."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from matplotlib.figure import Figure

from tacos_report.figures.canvas import NARROW_IN, draw, light_grid, name_rows
from tacos_report.palette import DOT, INK, MUTED, RULE, camera_colour
from tacos_report.quantities import number, row_detail, shown, words
from tacos_report.study_data import Tried

_SHOWN = 10
_NARROW_LETTERS = 50
"""So many letters fit the width of a phone."""


def catalog_choices(
    variable: str, tried: Sequence[Tried], designed: str | None, *, narrow: bool = False
) -> str:
    """SVG of the best rows of a catalog variable, each with the fitness of every candidate that used it.

    `designed`: name of the row that the designed camera has; it is shown wherever it ranks, if it was tried.
    """
    rows = _ranked(variable, tried)
    best = [row for place, row in enumerate(rows) if place < _SHOWN or row[0] == designed]
    names = ", ".join(f"{name} {number(max(values))}" for name, _, values in best)
    label = words(variable).lower()
    description = f"Best fitness by {label}, {len(best)} of {len(rows)} tried: {names}."

    def paint(figure: Figure) -> None:
        axes = figure.add_subplot()
        left = min(min(values) for _, _, values in best)
        colours = [camera_colour(0) if name == designed else INK for name, _, _ in best]
        weights = ["bold" if name == designed else "normal" for name, _, _ in best]
        for place, (_, _, values) in enumerate(best):
            top, colour = max(values), colours[place]
            axes.plot([min(values), top], [place, place], color=RULE, linewidth=2.5, zorder=0)
            axes.plot(values, [place] * len(values), "o", color=DOT, alpha=0.5, markersize=5, linestyle="")
            axes.plot([top], [place], "o", color=colour, markersize=6, linestyle="")
            axes.annotate(
                number(top), (top, place), (9, 0), textcoords="offset points", va="center", color=colour,
                fontweight=weights[place],
            )  # fmt: skip
        labels = name_rows(
            axes, [_label(row, values, narrow=narrow) for _, row, values in best], narrow=narrow
        )
        for text, colour, weight in zip(labels, colours, weights, strict=True):
            text.set(color=colour, fontweight=weight)
        axes.set_ylim(len(best) - 0.4, -0.9 if narrow else -0.6)
        axes.margins(x=0.12 if narrow else 0.1)
        axes.set_xlabel(f"fitness of each candidate with that {label}", color=MUTED)
        axes.spines[["left", "bottom"]].set_visible(False)
        axes.set_xlim(left=left - 0.04 * abs(left))
        light_grid(axes, "x")

    if narrow:
        return draw(f"catalog-{variable}-narrow", (NARROW_IN, 0.8 + 0.42 * len(best)), description, paint)
    return draw(f"catalog-{variable}", (9.2, 0.75 + 0.31 * len(best)), description, paint)


def _ranked(variable: str, tried: Sequence[Tried]) -> list[tuple[str, dict[str, Any], list[float]]]:
    """(name, row, fitnesses) of every row tried, the best first."""
    fitnesses: dict[str, list[float]] = {}
    rows: dict[str, dict[str, Any]] = {}
    for candidate in tried:
        row = candidate.camera.get(variable)
        if isinstance(row, dict) and candidate.fitness is not None:
            name = str(row.get("name", "unnamed"))
            fitnesses.setdefault(name, []).append(candidate.fitness)
            rows[name] = row
    ranked = sorted(fitnesses, key=lambda name: (-max(fitnesses[name]), name))
    return [(name, rows[name], fitnesses[name]) for name in ranked]


def _label(row: dict[str, Any], values: Sequence[float], *, narrow: bool) -> str:
    """A row by its title; on a phone without its details where they would not fit."""
    title, times = shown("part", row), f"tried {len(values)}×"
    whole = "  ·  ".join(part for part in (title, row_detail(row), times) if part)
    return whole if not narrow or len(whole) <= _NARROW_LETTERS else f"{title}  ·  {times}"
