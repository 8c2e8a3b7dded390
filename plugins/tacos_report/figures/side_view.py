"""The vertical fields of view, seen from the side: eye, horizon, floor."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyBboxPatch, Polygon

from tacos_framework.report.figures.canvas import draw
from tacos_framework.report.palette import INK, MUTED, RULE, camera_colour
from tacos_framework.report.quantities import quantity
from tacos_report.story import floor_words
from tacos_report.study_data import CameraResult
from tacos_report.view_geometry import floor_range_m, wedge

_REACH_M = 4.6
_ROW_M = 0.27


def side_view(cameras: Sequence[CameraResult], eye_height_m: float) -> str:
    """SVG of all vertical fields of view from one eye, and of the floor each sees.

    Cameras without ``vfov_deg`` are left out; the colour of each is that of its place in `cameras`.
    """
    drawn = [(index, camera) for index, camera in enumerate(cameras) if "vfov_deg" in camera.derived]
    floors = "; ".join(f"{camera.title} {floor_words(camera, eye_height_m)}" for _, camera in drawn)
    description = (
        f"Side view from an eye {quantity(eye_height_m, 'm')} above the floor. Floor seen: {floors}."
    )
    bottom = -0.5 - _ROW_M * len(drawn)
    highest = max([camera.pitch_deg + camera.derived["vfov_deg"] / 2 for _, camera in drawn], default=0.0)
    rise_m = _REACH_M * math.sin(math.radians(min(90.0, max(0.0, highest))))
    top = eye_height_m + min(3.4, max(0.6, rise_m + 0.2))

    def paint(figure: Figure) -> None:
        axes = figure.add_subplot()
        axes.set_aspect("equal")
        axes.set_xlim(-1.55, 5.2)
        axes.set_ylim(bottom - 0.35, top)
        axes.axis("off")
        _agent(axes, eye_height_m)
        axes.plot([-1.5, 5.1], [0, 0], color=INK, linewidth=1.4, solid_capstyle="butt")
        axes.plot([0.3, 5.1], [eye_height_m] * 2, color=MUTED, linewidth=0.7, dashes=(4, 3))
        axes.text(5.15, eye_height_m + 0.06, "horizon", color=MUTED, ha="right", fontsize=8)
        for index, camera in reversed(drawn):  # the designed camera last, on top
            _view(axes, camera, index, eye_height_m)
        for row, (index, camera) in enumerate(drawn):
            _floor_strip(axes, camera, index, eye_height_m, -0.28 - _ROW_M * row)
        _distances(axes, bottom)

    return draw("side-view", (6.9, 6.9 * (top - bottom + 0.35) / 6.75), description, paint)


def _agent(axes: Axes, eye_height_m: float) -> None:
    axes.add_patch(Circle((-0.14, eye_height_m), 0.13, color=RULE, linewidth=0))
    body = (-0.31, 0.03), 0.34, max(0.1, eye_height_m - 0.26)
    axes.add_patch(FancyBboxPatch(*body, boxstyle="round,pad=0,rounding_size=0.14", color=RULE, linewidth=0))
    axes.plot([0], [eye_height_m], "o", color=INK, markersize=4.5, zorder=5)
    label = f"eye at {quantity(eye_height_m, 'm')}"
    axes.text(-0.42, eye_height_m, label, color=MUTED, ha="right", va="center", fontsize=8)


def _view(axes: Axes, camera: CameraResult, index: int, eye_height_m: float) -> None:
    half = camera.derived["vfov_deg"] / 2
    eye = (0.0, eye_height_m)
    outline = wedge(eye, camera.pitch_deg - half, camera.pitch_deg + half, _REACH_M, floor=0.0)
    colour, first = camera_colour(index), index == 0
    style: dict[str, Any] = {"edgecolor": colour, "linewidth": 2.2 if first else 1.4, "joinstyle": "round"}
    axes.add_patch(Polygon(outline, facecolor="none", zorder=2, **style))
    if first:  # its own fill lies below every outline, so that no colour is muddied
        axes.add_patch(Polygon(outline, facecolor=colour, edgecolor="none", alpha=0.13, zorder=0))
        axis = wedge(eye, camera.pitch_deg, camera.pitch_deg, _REACH_M, floor=0.0)[-1]
        axes.plot([0, axis[0]], [eye_height_m, axis[1]], color=colour, linewidth=1.0, dashes=(2, 2.5))


def _floor_strip(axes: Axes, camera: CameraResult, index: int, eye_height_m: float, z_m: float) -> None:
    """A bar below the floor where this camera sees it."""
    seen = floor_range_m(eye_height_m, camera.pitch_deg, camera.derived["vfov_deg"])
    colour = camera_colour(index)
    if seen is None or seen[0] > 5.0:
        axes.text(-0.1, z_m, floor_words(camera, eye_height_m), color=colour, va="center", fontsize=8.5)
        return
    near, far = seen[0], min(seen[1], 5.1)
    axes.plot([near, far], [z_m, z_m], color=colour, linewidth=6, solid_capstyle="butt")
    axes.plot([near] * 2, [z_m, 0], color=colour, linewidth=0.8, alpha=0.7)
    label = "at the feet" if near < 0.05 else quantity(near, "m", digits=2)
    axes.text(near - 0.08, z_m, label, color=colour, ha="right", va="center", fontsize=9, fontweight="bold")
    if math.isfinite(seen[1]) and seen[1] < 5.0:
        axes.text(far + 0.06, z_m, quantity(far, "m", digits=2), color=colour, va="center", fontsize=9)


def _distances(axes: Axes, bottom: float) -> None:
    for metre in range(6):
        axes.plot([metre] * 2, [bottom + 0.06, bottom + 0.13], color=MUTED, linewidth=0.8)
        axes.text(metre, bottom, f"{metre} m", color=MUTED, ha="center", va="top", fontsize=8)
    axes.text(-0.35, bottom, "floor seen from", color=MUTED, ha="right", va="top", fontsize=8)
