"""Carriers of a camera, drawn from the side in metres: the camera is at x = 0 and looks to the right."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from matplotlib.axes import Axes
from matplotlib.patches import Circle, FancyBboxPatch, Polygon

from tacos_report.palette import MUTED, PAPER, RULE


@dataclass(frozen=True)
class Carrier:
    paint: Callable[[Axes, float], None]  # draws it on axes in metres, with the camera at a height
    behind_m: float  # room that the drawing needs behind the camera
    ahead_m: float  # how far ahead it reaches
    camera: str  # what the camera is called on it


def carrier_of(name: str) -> Carrier:
    """The carrier of a name that scenes give; a mast, which nobody mistakes for one, for any other."""
    return _CARRIERS.get(name, _MAST)


def _person(axes: Axes, height_m: float) -> None:
    axes.add_patch(Circle((-0.14, height_m), 0.13, color=RULE, linewidth=0))
    body = (-0.31, 0.03), 0.34, max(0.1, height_m - 0.26)
    axes.add_patch(FancyBboxPatch(*body, boxstyle="round,pad=0,rounding_size=0.14", color=RULE, linewidth=0))


def _car(axes: Axes, height_m: float) -> None:
    """A saloon of 4.4 x 1.5 m, with the camera above the front edge of its roof."""
    outline = [
        (-2.6, 0.35), (-2.6, 0.95), (-1.9, 1.02), (-1.35, 1.46), (0.0, 1.5), (0.75, 1.0), (1.7, 0.85),
        (1.8, 0.6), (1.8, 0.35),
    ]  # fmt: skip
    axes.add_patch(Polygon(outline, closed=True, color=RULE, linewidth=0, joinstyle="round"))
    windows = [(-1.55, 1.02), (-1.2, 1.38), (-0.05, 1.41), (0.5, 1.02)]
    axes.add_patch(Polygon(windows, closed=True, color=PAPER, linewidth=0))
    for x_m in (-1.75, 1.05):
        axes.add_patch(Circle((x_m, 0.33), 0.33, color=MUTED, linewidth=0))
        axes.add_patch(Circle((x_m, 0.33), 0.17, color=PAPER, linewidth=0))
    if height_m > 1.5:
        axes.plot([-0.12, 0.0], [1.5, height_m], color=MUTED, linewidth=1.6)


def _mast(axes: Axes, height_m: float) -> None:
    axes.plot([0, 0], [0, height_m], color=RULE, linewidth=4, solid_capstyle="butt")


_MAST = Carrier(_mast, 1.55, 5.2, "camera")
_CARRIERS: Mapping[str, Carrier] = {
    "person": Carrier(_person, 1.55, 5.2, "eye"),
    "car": Carrier(_car, 4.6, 15.6, "camera"),
}
