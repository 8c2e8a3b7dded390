"""Variance over signal, with the lines that explain it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from tacos_report.figures.canvas import NARROW_IN, draw, light_grid
from tacos_report.palette import MUTED, RULE, camera_colour

CHANNEL_COLOURS = {
    "R": camera_colour(0),
    "G": camera_colour(2),
    "B": camera_colour(1),
    "mono": camera_colour(5),
}
"""Of the page's own palette, close to what the channels are."""

_DOT: dict[str, Any] = {
    "marker": "o",
    "linestyle": "",
    "markersize": 3.2,
    "markeredgewidth": 0,
    "alpha": 0.75,
}


@dataclass(frozen=True, eq=False)
class Cloud:
    """Measured levels of a channel and a line to hold against them."""

    channel: str
    signal_dn: NDArray[np.float64]
    variance_dn2: NDArray[np.float64]
    """(L,) measured, above black [DN, DN^2]."""
    error_dn2: NDArray[np.float64]
    """(L,) standard error of the variance [DN^2]."""
    used: NDArray[np.bool_]
    """(L,) which levels count; the others are drawn faintly."""
    line_dn2: NDArray[np.float64]
    """(L,) the line at those signals [DN^2]."""


def photon_transfer(
    name: str, panels: Sequence[tuple[str, Sequence[Cloud]]], *, line: str, narrow: bool = False
) -> str:
    """SVG of a panel per setting, each with what is left over below.

    - `name`: unique among the drawings of a page.
    - `panels`: title and clouds of each.
    - `line`: what the lines are, for the legend.
    - `narrow`: for the width of a phone: settings stand below each other.
    """
    figures = ", ".join(title for title, _ in panels)
    description = f"Variance over mean signal per channel, with {line} and residuals: {figures}."

    def paint(figure: Figure) -> None:
        for (title, clouds), (above, below) in zip(panels, _axes(figure, len(panels), narrow), strict=True):
            for cloud in clouds:
                colour = CHANNEL_COLOURS[cloud.channel]
                kept, left = cloud.used, ~cloud.used
                above.plot(cloud.signal_dn[left], cloud.variance_dn2[left], color=RULE, **_DOT)
                above.errorbar(
                    cloud.signal_dn[kept], cloud.variance_dn2[kept], 2 * cloud.error_dn2[kept],
                    color=colour, ecolor=colour, elinewidth=0.8, **_DOT, label=f"{cloud.channel}, measured",
                )  # fmt: skip
                above.plot(cloud.signal_dn, cloud.line_dn2, "-", color=colour, linewidth=1.4)
                rest = 100 * (cloud.variance_dn2 / cloud.line_dn2 - 1)
                below.plot(cloud.signal_dn[kept], rest[kept], color=colour, **_DOT)
            above.set_title(title)
            above.set_ylim(bottom=0)
            below.axhline(0, color=MUTED, linewidth=0.8)
            below.set_xlabel("signal above black [DN]")
            for axes in (above, below):
                light_grid(axes, "y")
            if narrow or title == panels[0][0]:
                above.set_ylabel("variance [DN²]")
                below.set_ylabel("off the line [%]")
        figure.axes[0].legend(loc="upper left", labelcolor=MUTED)

    if narrow:
        return draw(f"{name}-narrow", (NARROW_IN, 4.2 * len(panels)), description, paint)
    return draw(name, (4.6 * max(len(panels), 1.6), 4.6), description, paint)


def _axes(figure: Figure, count: int, narrow: bool) -> list[tuple[Axes, Axes]]:
    """For each setting, axes of its variance and axes below of what is left over."""
    if not narrow:
        above, below = figure.subplots(2, count, squeeze=False, sharex="col", height_ratios=(3, 1))
        return list(zip(above, below, strict=True))
    column = figure.subplots(2 * count, 1, height_ratios=(3, 1) * count)
    pairs = list(zip(column[::2], column[1::2], strict=True))
    for variance, rest in pairs:
        rest.sharex(variance)
        variance.tick_params(labelbottom=False)
    return pairs
