"""The vertical fields of view, seen from the side: camera, horizon, floor."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from tacos_report.figures.canvas import draw
from tacos_report.figures.carriers import Carrier, carrier_of
from tacos_report.palette import INK, MUTED, camera_colour
from tacos_report.quantities import quantity
from tacos_report.story import floor_words
from tacos_report.study_data import CameraResult
from tacos_report.view_geometry import floor_range_m, wedge

_WIDTH_IN = 6.9
_ROW_SHARE = 0.04
"""Height of a row below the floor, as a share of the drawing's width."""


@dataclass(frozen=True)
class _Stage:
    """The ground the drawing covers: what carries the cameras, how high, and what it moves on."""

    carrier: Carrier
    height_m: float
    ground: str

    @property
    def width_m(self) -> float:
        return self.carrier.behind_m + self.carrier.ahead_m

    @property
    def reach_m(self) -> float:
        """Length of the drawn views: the rest of the width is for labels [m]."""
        return 0.885 * self.carrier.ahead_m

    @property
    def row_m(self) -> float:
        return _ROW_SHARE * self.width_m


def side_view(
    cameras: Sequence[CameraResult], height_m: float, carried_by: str = "", ground: str = "floor"
) -> str:
    """SVG of all vertical fields of view from one place, and of the floor each sees.

    Cameras without ``vfov_deg`` are left out; the colour of each is that of its place in `cameras`.

    `height_m`: height of the cameras above the ground [m]. `carried_by`: what carries them, as scenes say:
    ``person``, ``car``.
    """
    stage = _Stage(carrier_of(carried_by), height_m, ground)
    drawn = [(index, camera) for index, camera in enumerate(cameras) if "vfov_deg" in camera.derived]
    floors = "; ".join(f"{camera.title} {floor_words(camera, height_m, ground)}" for _, camera in drawn)
    at = f"Side view from {quantity(height_m, 'm')} above the {ground}"
    bottom = -stage.row_m * (1.85 + len(drawn))
    highest = max([camera.pitch_deg + camera.derived["vfov_deg"] / 2 for _, camera in drawn], default=0.0)
    rise_m = stage.reach_m * math.sin(math.radians(min(90.0, max(0.0, highest))))
    top = height_m + min(0.74 * stage.reach_m, max(0.13 * stage.reach_m, 1.04 * rise_m))
    foot = bottom - 1.3 * stage.row_m

    def paint(figure: Figure) -> None:
        axes = figure.add_subplot()
        axes.set_aspect("equal")
        axes.set_xlim(-stage.carrier.behind_m, stage.carrier.ahead_m)
        axes.set_ylim(foot, top)
        axes.axis("off")
        _surroundings(axes, stage)
        for index, camera in reversed(drawn):  # the designed camera last, on top
            _view(axes, camera, index, stage)
        for row, (index, camera) in enumerate(drawn):
            _floor_strip(axes, camera, index, stage, -stage.row_m * (1.04 + row))
        _distances(axes, bottom, stage)

    size_in = _WIDTH_IN, _WIDTH_IN * (top - foot) / stage.width_m
    return draw("side-view", size_in, f"{at}. Seen of it: {floors}.", paint)


def _surroundings(axes: Axes, stage: _Stage) -> None:
    ahead, height_m = 0.98 * stage.carrier.ahead_m, stage.height_m
    stage.carrier.paint(axes, height_m)
    axes.plot([0], [height_m], "o", color=INK, markersize=4.5, zorder=5)
    label = f"{stage.carrier.camera} at {quantity(height_m, 'm')}"
    side = -0.062 * stage.width_m
    axes.text(side, height_m + 0.012 * stage.width_m, label, color=MUTED, ha="right", fontsize=8)
    axes.plot(
        [-stage.carrier.behind_m * 0.97, ahead], [0, 0], color=INK, linewidth=1.4, solid_capstyle="butt"
    )
    axes.plot([0.06 * ahead, ahead], [height_m] * 2, color=MUTED, linewidth=0.7, dashes=(4, 3))
    axes.text(1.01 * ahead, height_m + 0.009 * stage.width_m, "horizon", color=MUTED, ha="right", fontsize=8)


def _view(axes: Axes, camera: CameraResult, index: int, stage: _Stage) -> None:
    half = camera.derived["vfov_deg"] / 2
    eye = (0.0, stage.height_m)
    outline = wedge(eye, camera.pitch_deg - half, camera.pitch_deg + half, stage.reach_m, floor=0.0)
    colour, first = camera_colour(index), index == 0
    style: dict[str, Any] = {"edgecolor": colour, "linewidth": 2.2 if first else 1.4, "joinstyle": "round"}
    axes.add_patch(Polygon(outline, facecolor="none", zorder=2, **style))
    if first:  # its own fill lies below every outline, so that no colour is muddied
        axes.add_patch(Polygon(outline, facecolor=colour, edgecolor="none", alpha=0.13, zorder=0))
        axis = wedge(eye, camera.pitch_deg, camera.pitch_deg, stage.reach_m, floor=0.0)[-1]
        axes.plot([0, axis[0]], [stage.height_m, axis[1]], color=colour, linewidth=1.0, dashes=(2, 2.5))


def _floor_strip(axes: Axes, camera: CameraResult, index: int, stage: _Stage, z_m: float) -> None:
    """A bar below the floor where this camera sees it."""
    seen = floor_range_m(stage.height_m, camera.pitch_deg, camera.derived["vfov_deg"])
    colour, end_m, gap_m = camera_colour(index), 0.98 * stage.carrier.ahead_m, 0.012 * stage.width_m
    if seen is None or seen[0] > 0.96 * stage.carrier.ahead_m:
        said = floor_words(camera, stage.height_m, stage.ground)
        axes.text(-gap_m, z_m, said, color=colour, va="center", fontsize=8.5)
        return
    near, far = seen[0], min(seen[1], end_m)
    axes.plot([near, far], [z_m, z_m], color=colour, linewidth=6, solid_capstyle="butt")
    axes.plot([near] * 2, [z_m, 0], color=colour, linewidth=0.8, alpha=0.7)
    label = "at the feet" if near < 0.05 else quantity(near, "m", digits=2)
    axes.text(near - gap_m, z_m, label, color=colour, ha="right", va="center", fontsize=9, fontweight="bold")
    if math.isfinite(seen[1]) and seen[1] < end_m:
        axes.text(far + gap_m, z_m, quantity(far, "m", digits=2), color=colour, va="center", fontsize=9)


def _distances(axes: Axes, bottom: float, stage: _Stage) -> None:
    tick_m = 0.01 * stage.width_m
    step = 1 if stage.carrier.ahead_m < 8 else 3
    for metre in range(0, int(stage.carrier.ahead_m) + 1, step):
        axes.plot([metre] * 2, [bottom + tick_m, bottom + 2 * tick_m], color=MUTED, linewidth=0.8)
        axes.text(metre, bottom, f"{metre} m", color=MUTED, ha="center", va="top", fontsize=8)
    label = f"{stage.ground} seen from"
    axes.text(-0.052 * stage.width_m, bottom, label, color=MUTED, ha="right", va="top", fontsize=8)
