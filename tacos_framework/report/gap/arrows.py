"""Displacements over the image as arrows, before and after, drawn longer than they are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from tacos_framework.gap.boards import BoardEvidence
from tacos_framework.gap.problem import Problem
from tacos_framework.report.figures.canvas import draw
from tacos_framework.report.gap.numbers import Numbers
from tacos_framework.report.gap.series import AFTER, BEFORE
from tacos_framework.report.palette import MUTED, RULE
from tacos_framework.report.quantities import number


@dataclass(frozen=True, eq=False)
class Displacements:
    """Arrows over an image.

    Parameters
    ----------
    places_px
        (K, 2) where they start, x and y [px].
    before_px, after_px
        (K, 2) real less simulated position [px].
    size_px
        Width and height of the image [px].
    """

    places_px: NDArray[np.float64]
    before_px: NDArray[np.float64]
    after_px: NDArray[np.float64]
    size_px: tuple[int, int]


def of_tiles(numbers: Numbers) -> Displacements:
    """Displacements of tiles; where several captures share a tile, their mean."""
    found: dict[tuple[int, ...], dict[str, list[tuple[float, float]]]] = {}
    for label, a, b, sigma in zip(
        numbers.labels, numbers.z_before, numbers.z_after, numbers.sigma, strict=True
    ):
        pair = float(a * sigma), float(b * sigma)
        found.setdefault(tuple(label.at["box_px"]), {}).setdefault(label.at["axis"], []).append(pair)
    whole = {box: axes for box, axes in found.items() if len(axes) == 2}
    places = [((box[0] + box[2]) / 2, (box[1] + box[3]) / 2) for box in whole]
    means = np.array([[np.mean(axes[axis], axis=0) for axis in "xy"] for axes in whole.values()])
    size = max(box[2] for box in found), max(box[3] for box in found)
    return Displacements(np.array(places), means[:, :, 0], means[:, :, 1], size)


def of_boards(problem: Problem, numbers: Numbers) -> Displacements:
    """Misfits of the corners of all views."""
    places = [e.corners_px for e in problem.evidence if isinstance(e, BoardEvidence)]
    geometry = next(e.capture.geometry for e in problem.evidence if isinstance(e, BoardEvidence))
    pairs = []
    for moved_px in (numbers.z_before * numbers.sigma, numbers.z_after * numbers.sigma):
        start, parts = 0, []
        for corners in places:
            stop = start + 2 * len(corners)
            parts.append(moved_px[start:stop].reshape(2, -1).T)  # all x of a view stand before all y
            start = stop
        pairs.append(np.concatenate(parts))
    before_px, after_px = pairs
    size_px = geometry.width_px, geometry.height_px
    return Displacements(np.concatenate(places), before_px, after_px, size_px)


def arrows(name: str, moved: Displacements, *, before: str, after: str | None) -> str:
    """SVG of two fields of arrows on one scale."""
    lengths = np.hypot(*moved.before_px.T)
    longest = max(float(np.percentile(lengths, 97)), 1e-6)
    width, height = moved.size_px
    factor = 0.09 * width / longest
    drawn = [(before, moved.before_px, BEFORE)]
    if after is not None:
        drawn.append((after, moved.after_px, AFTER))
    scale_px = _round_length(longest)

    def paint(figure: Figure) -> None:
        for axes, (title, field, colour) in zip(
            figure.subplots(1, len(drawn), squeeze=False)[0], drawn, strict=True
        ):
            axes.quiver(
                *moved.places_px.T, *(factor * field).T, angles="xy", scale_units="xy", scale=1,
                color=colour, width=0.0042, headwidth=4.5, headlength=5, minlength=0.4,
            )  # fmt: skip
            axes.plot(*moved.places_px.T, ".", color=RULE, markersize=2.5, zorder=0)
            axes.set(xlim=(0, width), ylim=(height, 0), aspect="equal", xticks=[], yticks=[])
            rms = number(float(np.sqrt(np.mean(field**2) * 2)), 2)
            axes.set_title(f"{title}: {rms} px rms")
            axes.spines[:].set(visible=True, color=RULE)
        axes.plot([0.03 * width, 0.03 * width + factor * scale_px], [0.965 * height] * 2, color=MUTED)
        axes.text(
            0.03 * width, 0.945 * height, f"{number(scale_px)} px, {number(factor, 2)} times as long",
            color=MUTED, fontsize=8,
        )  # fmt: skip

    description = f"Displacements over the image, up to {number(float(lengths.max()), 2)} px before."
    size_in = (9.2 if after is not None else 5.0, 0.4 + 4.5 * height / width)
    return draw(name, size_in, description, paint)


def _round_length(value: float) -> float:
    """The largest of 1, 2, 5 times a power of ten that is not above `value`."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(max(m for m in (1, 2, 5) if m * power <= value * 1.0001) * power)
