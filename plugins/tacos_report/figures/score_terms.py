"""Contributions to the fitness of each camera, as stacked bars."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from tacos_report.figures.canvas import NARROW_IN, draw, light_grid, name_rows
from tacos_report.palette import INK, PAPER, RULE, TERMS, camera_colour
from tacos_report.quantities import measured, number, words
from tacos_report.study_data import CameraResult

_LIGHT_TEXT_ON = {TERMS[0], TERMS[3], TERMS[5]}


def score_terms(cameras: Sequence[CameraResult], scores: Sequence[str], *, narrow: bool = False) -> str:
    """SVG of one bar per tested camera, one segment per term of the fitness, error bars where known.

    `scores`: the terms in the order they are stacked. `narrow`: for the width of a phone: names stand above
    the bars.
    """
    drawn = [(index, camera) for index, camera in enumerate(cameras) if camera.fitness is not None]
    totals = ", ".join(f"{camera.title} {number(camera.fitness or 0.0)}" for _, camera in drawn)

    def paint(figure: Figure) -> None:
        axes = figure.add_subplot()
        reach = 0.0
        for row, (_, camera) in enumerate(drawn):
            ends = {True: 0.0, False: 0.0}  # positive terms to the right, negative ones to the left
            for place, score in enumerate(scores):
                value = camera.terms.get(score, 0.0)
                colour = TERMS[place % len(TERMS)]
                start = ends[value >= 0]
                axes.barh(
                    row,
                    value,
                    left=start,
                    height=0.36 if narrow else 0.58,
                    color=colour,
                    edgecolor=PAPER,
                    linewidth=1,
                )
                ends[value >= 0] = start + value
            reach = max(reach, ends[True], camera.fitness or 0.0)
        for row, (index, camera) in enumerate(drawn):
            _segment_values(axes, row, camera, scores, reach)
            _total(axes, row, index, camera, reach)
        labels = name_rows(axes, [camera.title for _, camera in drawn], narrow=narrow)
        for label, (index, _) in zip(labels, drawn, strict=True):
            label.set(color=camera_colour(index), fontsize=10, fontweight="bold" if index == 0 else "normal")
        axes.set_ylim(len(drawn) - 0.5, -0.75 if narrow else -0.5)
        axes.axvline(0, color=RULE, linewidth=1)
        axes.set_xlim(right=reach * (1.35 if narrow else 1.2) or 1.0)
        between = "\n" if narrow else " "
        axes.set_xlabel(f"fitness: sum of weighted scores on unseen scenes{between}(higher is better)")
        axes.spines[["left", "bottom"]].set_visible(False)
        light_grid(axes, "x")
        swatches = [Patch(facecolor=TERMS[place % len(TERMS)], linewidth=0) for place in range(len(scores))]
        names = [words(score) for score in scores]
        figure.legend(
            swatches, names, loc="outside upper left", ncols=min(1 if narrow else 4, len(names)) or 1
        )

    said = f"Fitness on unseen scenes by camera: {totals}."
    if narrow:
        height = 0.95 + 0.17 * len(scores) + 0.52 * len(drawn)
        return draw("score-terms-narrow", (NARROW_IN, height), said, paint)
    return draw("score-terms", (9.2, 1.15 + 0.5 * len(drawn)), said, paint)


def _segment_values(axes: Axes, row: int, camera: CameraResult, scores: Sequence[str], reach: float) -> None:
    end = 0.0
    for place, score in enumerate(scores):
        value = camera.terms.get(score, 0.0)
        if value > 0.06 * reach:
            colour = "#ffffff" if TERMS[place % len(TERMS)] in _LIGHT_TEXT_ON else "#101418"
            axes.text(
                end + value / 2, row, number(value), color=colour, ha="center", va="center", fontsize=8.5
            )
        end += max(value, 0.0)


def _total(axes: Axes, row: int, index: int, camera: CameraResult, reach: float) -> None:
    fitness, error = camera.fitness or 0.0, camera.spread.get("fitness")
    if error:
        axes.errorbar(fitness, row, xerr=error, color=INK, capsize=3, linewidth=1.1, capthick=1.1)
    weight = "bold" if index == 0 else "normal"
    start = fitness + (error or 0.0) + 0.015 * reach
    axes.text(start, row, measured(fitness, error), color=INK, va="center", fontsize=10, fontweight=weight)
