"""Frequency of each code in a capture: real, before, after."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from tacos_framework.formation import EpisodeDraws, PlacedEffect
from tacos_gap.captures import RealCapture
from tacos_gap.report.series import AFTER, BEFORE, REAL
from tacos_gap.simulation.formation import simulate
from tacos_report.figures.canvas import draw, light_grid
from tacos_report.palette import MUTED, RULE

_MOST_CODES = 160


def histogram(
    name: str,
    capture: RealCapture,
    effects: Sequence[PlacedEffect],
    seed: int,
    *,
    before: str,
    after: str | None,
) -> str:
    """SVG of the shares of codes; of the densest part where there are many."""
    series = [("real", capture.real_dn, REAL)]
    draws = EpisodeDraws(seed, ("report", capture.id))
    series.append((before, simulate(capture, (), draws), BEFORE))
    if after is not None:
        series.append((after, simulate(capture, effects, draws), AFTER))
    low, high = _window(capture.real_dn[:, capture.valid])

    def paint(figure: Figure) -> None:
        for axes, (title, frames, colour) in zip(
            figure.subplots(len(series), 1, sharex=True, squeeze=False)[:, 0], series, strict=True
        ):
            values = frames[:, capture.valid].ravel().astype(np.int64)
            shares = np.bincount(np.clip(values, 0, high + 1), minlength=high + 2)[low : high + 1]
            axes.bar(np.arange(low, high + 1), 100 * shares / values.size, width=0.85, color=colour)
            axes.set_title(title, color=MUTED, fontsize=9)
            axes.set_yticks([])
            axes.spines["left"].set_visible(False)
            axes.spines["bottom"].set_color(RULE)
            light_grid(axes, "x")
        axes.set_xlabel(f"value of the file in {capture.id} [DN]")

    return draw(name, (5.0, 0.5 + 0.9 * len(series)), f"Histogram of codes of {capture.id}.", paint)


def _window(values: NDArray[np.float32]) -> tuple[int, int]:
    """The codes to show: all that are used, or the part around the middle."""
    low, high = (int(v) for v in np.percentile(values, (0.3, 99.7)))
    high = max(high, int(values.max())) if values.max() - low <= _MOST_CODES else high
    if high - low > _MOST_CODES:
        middle = int(np.median(values))
        low, high = max(low, middle - _MOST_CODES // 2), min(high, middle + _MOST_CODES // 2)
    return max(low - 2, 0), high + 2
