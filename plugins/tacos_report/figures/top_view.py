"""The horizontal fields of view, seen from above; rigs with all their cameras."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from tacos_report.figures.canvas import draw
from tacos_report.palette import INK, MUTED, RULE, camera_colour
from tacos_report.quantities import quantity
from tacos_report.study_data import CameraResult
from tacos_report.view_geometry import outlooks, wedge

_REACH_M = 4.0
_LABEL_GAP_M = 0.32


def top_view(cameras: Sequence[CameraResult]) -> str:
    """SVG of all horizontal fields of view; cameras without ``hfov_deg`` are left out."""
    drawn = [(index, camera) for index, camera in enumerate(cameras) if "hfov_deg" in camera.derived]
    angles = ", ".join(f"{camera.title} {quantity(camera.derived['hfov_deg'], 'deg')}" for _, camera in drawn)
    half_base = max([(camera.baseline_m or 0.0) / 2 for _, camera in drawn], default=0.0)
    around = any(len(outlooks(camera.derived)) > 1 for _, camera in drawn)
    behind = _REACH_M + 0.2 if around else 0.5
    side = (
        _REACH_M + 0.9
        if around
        else half_base + max([_half_width_m(camera) for _, camera in drawn], default=1.0) + 0.6
    )

    def paint(figure: Figure) -> None:
        axes = figure.add_subplot()
        axes.set_aspect("equal")
        axes.set_xlim(-side, side)
        axes.set_ylim(-behind, _REACH_M + 0.45)
        axes.axis("off")
        for metre in range(1, int(_REACH_M) + 1):
            arc = wedge((0.0, 0.0), *((0.0, 360.0) if around else (0.0, 180.0)), float(metre))[1:]
            axes.plot(*zip(*arc, strict=True), color=RULE, linewidth=0.6, zorder=0)
            axes.text(0, metre + 0.03, f"{metre} m", color=MUTED, ha="center", fontsize=8)
        for index, camera in reversed(drawn):
            _view(axes, camera, index)
        _labels(axes, drawn)
        axes.plot([0], [0], "o", color=INK, markersize=4.5, zorder=5)

    height = 5.6 * (_REACH_M + 0.45 + behind) / (2 * side)
    return draw("top-view", (5.6, height), f"Top view. Horizontal fields of view: {angles}.", paint)


def _half_width_m(camera: CameraResult) -> float:
    return _REACH_M * math.sin(math.radians(min(180.0, camera.derived["hfov_deg"]) / 2))


def _view(axes: Axes, camera: CameraResult, index: int) -> None:
    colour, first = camera_colour(index), index == 0
    base = camera.baseline_m or 0.0
    looks = [(x, *look) for x in sorted({-base / 2, base / 2}) for look in outlooks(camera.derived)]
    for x, yaw_deg, hfov_deg in looks:
        outline = wedge((x, 0.0), 90 + yaw_deg - hfov_deg / 2, 90 + yaw_deg + hfov_deg / 2, _REACH_M)
        if first:
            axes.add_patch(Polygon(outline, facecolor=colour, edgecolor="none", alpha=0.13, zorder=0))
        style: dict[str, Any] = {
            "edgecolor": colour,
            "linewidth": 2.2 if first else 1.4,
            "joinstyle": "round",
        }
        axes.add_patch(Polygon(outline, facecolor="none", zorder=2, **style))
    if base:
        axes.plot([-base / 2, base / 2], [-0.06, -0.06], color=colour, linewidth=2)
        label = f"baseline {quantity(base, 'm')}"
        axes.text(0, -0.14 - 0.22 * index, label, color=colour, ha="center", va="top", fontsize=8)


def _labels(axes: Axes, drawn: Sequence[tuple[int, CameraResult]]) -> None:
    """The angles, on the right-hand edges, pushed apart where edges are close."""
    below = math.inf
    for index, camera in sorted(drawn, key=lambda pair: pair[1].derived["hfov_deg"]):
        half = math.radians(camera.derived["hfov_deg"] / 2)
        offset = (camera.baseline_m or 0.0) / 2
        x, y = offset + (_REACH_M + 0.08) * math.sin(half), (_REACH_M + 0.08) * math.cos(half)
        y = min(y, below - _LABEL_GAP_M)
        below = y
        angle = quantity(camera.derived["hfov_deg"], "deg")
        axes.text(x, y, angle, color=camera_colour(index), va="center", fontsize=9, fontweight="bold")
