"""A statistic over the image: tiles coloured by real less simulated, before and after."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from numpy.typing import NDArray

from tacos_gap.report.numbers import Numbers
from tacos_gap.statistics.views import view_of
from tacos_report.figures.canvas import NARROW_IN, draw
from tacos_report.palette import MUTED, RULE
from tacos_report.quantities import number

DIVERGING = LinearSegmentedColormap.from_list(
    "less-more", ["#0b6aa8", "#9ec7e2", "#f7f7f5", "#efb58a", "#cb5b05"]
)
"""Blue where real is less, vermilion where more; not of the palette, whose colours change in dark mode."""

Box = tuple[int, int, int, int]


def image_map(name: str, numbers: Numbers, *, before: str, after: str | None, narrow: bool = False) -> str:
    """SVG of two maps on one scale.

    - `numbers`: numbers with a ``box_px`` each; where several captures or channels share a box, their mean is
      shown.
    - `before`, `after`: titles of the maps; without `after` there is one.
    - `narrow`: for the width of a phone: the maps stand below each other.
    """
    view = view_of(numbers.statistic)
    boxes, fields = _fields(numbers)
    shown = [view.shown(field) for field in fields]
    titles = [before] if after is None else [before, after]
    reach = max(float(np.percentile(np.abs(shown[0]), 98)), 1e-9)
    width, height = max(box[2] for box in boxes), max(box[3] for box in boxes)
    norm = Normalize(-reach, reach)
    lowest, highest = (number(float(end), 2) for end in (shown[0].min(), shown[0].max()))

    def paint(figure: Figure) -> None:
        panels = figure.subplots(*((len(titles), 1) if narrow else (1, len(titles))), squeeze=False).ravel()
        for axes, title, values in zip(panels, titles, shown, strict=False):
            for box, value in zip(boxes, values, strict=True):
                corner, size = (box[0], box[1]), (box[2] - box[0], box[3] - box[1])
                axes.add_patch(
                    Rectangle(corner, *size, facecolor=DIVERGING(norm(value)), edgecolor=RULE, linewidth=0.4)
                )
                red, green, blue, _ = DIVERGING(norm(value))
                light = 0.3 * red + 0.6 * green + 0.1 * blue < 0.55
                axes.text(
                    corner[0] + size[0] / 2, corner[1] + size[1] / 2, _brief(value, reach),
                    ha="center", va="center", fontsize=7, color="#ffffff" if light else "#23272e",
                )  # fmt: skip
            axes.set(xlim=(0, width), ylim=(height, 0), aspect="equal", xticks=[], yticks=[], title=title)
            axes.spines[:].set_visible(False)
        where: Any = {"location": "bottom" if narrow else "right", "shrink": 0.8, "aspect": 24}
        bar = figure.colorbar(ScalarMappable(norm, DIVERGING), ax=list(panels), **where)
        bar.outline.set_visible(False)
        bar.set_label(f"{view.quantity}", color=MUTED)

    description = f"{view.title}, tile by tile: {lowest} to {highest} before."
    size_in = (9.2, 0.4 + 3.8 * height / width) if after is not None else (5.0, 0.4 + 3.8 * height / width)
    if narrow:
        name, size_in = f"{name}-narrow", (NARROW_IN, 0.7 + (0.3 + 4.2 * height / width) * len(titles))
    return draw(name, size_in, description, paint)


def _brief(value: float, reach: float) -> str:
    decimals = int(np.clip(1 - np.floor(np.log10(reach)), 0, 4))
    text = f"{value:+.{decimals}f}"
    return "0" if float(text) == 0 else text.replace("-", "\u2212")


def _fields(numbers: Numbers) -> tuple[list[Box], Sequence[NDArray[np.float64]]]:
    """Mean difference of each box, before and after, in the statistic's unit."""
    members: dict[Box, list[int]] = {}
    for k, label in enumerate(numbers.labels):
        x0, y0, x1, y1 = label.at["box_px"]
        members.setdefault((x0, y0, x1, y1), []).append(k)
    fields = [
        np.array([float(np.mean(z[kept] * numbers.sigma[kept])) for kept in members.values()])
        for z in (numbers.z_before, numbers.z_after)
    ]
    return list(members), fields
