"""Drawings of a validation of cameras."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from tacos_gap.report.series import AFTER, BEFORE, REAL
from tacos_report.figures.canvas import draw, light_grid
from tacos_report.palette import INK, MUTED
from tacos_validation.cameras_validated.noise_curves import NoiseCurve
from tacos_validation.cameras_validated.ranking import CameraScores, level

MARKS = {"real": ("o", REAL), "sim_before": ("s", BEFORE), "sim_after": ("D", AFTER)}
TITLES = {"real": "real", "sim_before": "simulated", "sim_after": "simulated with the causes"}


def levels(scores: CameraScores, seed: int) -> str:
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
        axes.set_yticks(range(len(order)), order)
        axes.set(ylim=(len(order) - 0.5, -0.5), xlabel=scores.score.replace(".", ": ").replace("_", " "))
        axes.tick_params(axis="y", labelcolor=INK, labelsize=10)
        light_grid(axes, "x")
        figure.legend(handles=_handles(), loc="outside upper left", ncols=3, labelcolor=MUTED)

    said = "; ".join(f"{TITLES[stack]}: {', '.join(scores.order(stack))}" for stack in MARKS)
    name = f"levels-{scores.score.replace('.', '-')}"
    return draw(name, (8.0, 0.9 + 0.62 * len(scores.cameras)), f"{scores.score}, best first. {said}.", paint)


def noise(curves: Mapping[str, NoiseCurve]) -> str:
    """SVG of a panel per camera: variance over signal, real and simulated."""

    def paint(figure: Figure) -> None:
        columns = min(3, len(curves))
        rows = -(-len(curves) // columns)
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
        figure.legend(handles=_handles(), loc="outside upper left", ncols=3, labelcolor=MUTED)

    size = (4.0 * min(3, max(len(curves), 2)), 0.6 + 3.0 * -(-len(curves) // 3))
    return draw("noise", size, f"Variance over signal of {', '.join(curves)}.", paint)


def _handles() -> list[Line2D]:
    return [
        Line2D([], [], color=colour, marker=mark, linestyle="", markersize=6, label=TITLES[stack])
        for stack, (mark, colour) in MARKS.items()
    ]
