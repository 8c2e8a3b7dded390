"""Drawings of a validation of cameras."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from tacos_gap.report.series import AFTER, BEFORE, REAL
from tacos_report.figures.canvas import NARROW_IN, draw, light_grid, name_rows
from tacos_report.palette import INK, MUTED
from tacos_validation.cameras_validated.noise_curves import NoiseCurve
from tacos_validation.cameras_validated.ranking import CameraScores, level

MARKS = {"real": ("o", REAL), "sim_before": ("s", BEFORE), "sim_after": ("D", AFTER)}
TITLES = {"real": "real", "sim_before": "simulated", "sim_after": "simulated with the causes"}


def levels(scores: CameraScores, seed: int, *, narrow: bool = False) -> str:
    """SVG of a row per camera: its score in reality and in both simulations, each with its interval."""

    def paint(figure: Figure) -> None:
        axes = figure.add_subplot()
        order = scores.order("real")
        for row, camera in enumerate(order):
            for offset, (stack, (mark, colour)) in zip((-0.22, 0.0, 0.22), MARKS.items(), strict=True):
                found = level(scores, stack, scores.cameras.index(camera), seed)
                place = row + offset
                axes.plot([found.low, found.high], [place, place], color=colour, linewidth=1.4)
                axes.plot([found.mean], [place], mark, color=colour, markersize=6)
        for label in name_rows(axes, order, narrow=narrow):
            label.set(color=INK, fontsize=10)
            if narrow:
                label.set_position((0, 17))  # above the first of its three dots
        axes.set(
            ylim=(len(order) - 0.5, -0.9 if narrow else -0.5),
            xlabel=scores.score.replace(".", ": ").replace("_", " "),
        )
        light_grid(axes, "x")
        _legend(figure, narrow=narrow)

    said = "; ".join(f"{TITLES[stack]}: {', '.join(scores.order(stack))}" for stack in MARKS)
    name = f"levels-{scores.score.replace('.', '-')}"
    description = f"{scores.score}, best first. {said}."
    if narrow:
        return draw(f"{name}-narrow", (NARROW_IN, 1.3 + 0.8 * len(scores.cameras)), description, paint)
    return draw(name, (8.0, 0.9 + 0.62 * len(scores.cameras)), description, paint)


def noise(curves: Mapping[str, NoiseCurve], *, narrow: bool = False) -> str:
    """SVG of a panel per camera: variance over signal, real and simulated; below each other if narrow."""
    columns = 1 if narrow else min(3, len(curves))
    rows = -(-len(curves) // columns)

    def paint(figure: Figure) -> None:
        panels = np.atleast_1d(figure.subplots(rows, columns, squeeze=False)).ravel()
        for axes, (camera, curve) in zip(panels, curves.items(), strict=False):
            for stack, (mark, colour) in MARKS.items():
                found = curve.levels[stack]
                axes.plot(found.mean_dn, found.variance_dn2, mark, color=colour, markersize=3.4, alpha=0.75)
            axes.set_title(camera)
            axes.set_ylim(bottom=0)
            axes.set(xlabel="signal with pedestal [DN]", ylabel="variance [DN²]")
            light_grid(axes, "y")
        for axes in panels[len(curves) :]:
            axes.set_visible(False)
        _legend(figure, narrow=narrow)

    description = f"Variance over signal of {', '.join(curves)}."
    if narrow:
        return draw("noise-narrow", (NARROW_IN, 0.9 + 2.6 * rows), description, paint)
    return draw("noise", (4.0 * max(columns, 2), 0.6 + 3.0 * rows), description, paint)


def _legend(figure: Figure, *, narrow: bool) -> None:
    handles = [
        Line2D([], [], color=colour, marker=mark, linestyle="", markersize=6, label=TITLES[stack])
        for stack, (mark, colour) in MARKS.items()
    ]
    figure.legend(handles=handles, loc="outside upper left", ncols=1 if narrow else 3, labelcolor=MUTED)
