"""Displacements over the image as arrows, before and after, drawn longer than they are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from tacos_gap.evidence.boards import BoardEvidence
from tacos_gap.inference.problem import Problem
from tacos_gap.report.numbers import Numbers
from tacos_gap.report.series import AFTER, BEFORE
from tacos_report.figures.canvas import NARROW_IN, draw
from tacos_report.palette import MUTED, RULE
from tacos_report.quantities import number


@dataclass(frozen=True, eq=False)
class Displacements:
    """Arrows over an image."""

    title: str
    places_px: NDArray[np.float64]  # (K, 2) where they start, x and y [px]
    before_px: NDArray[np.float64]  # (K, 2) real less simulated position
    after_px: NDArray[np.float64]  # (K, 2)
    size_px: tuple[int, int]  # width and height of the image [px]


def of_tiles(numbers: Numbers) -> list[Displacements]:
    """Displacements of tiles, one field per pair of channels; where captures share a tile, their mean."""
    titles = [str(label.at.get("channels", "")) for label in numbers.labels]
    return [
        _field(title, numbers.chosen(np.array([own == title for own in titles])))
        for title in dict.fromkeys(titles)
    ]


def _field(title: str, numbers: Numbers) -> Displacements:
    members: dict[tuple[int, ...], dict[str, list[int]]] = {}
    for k, label in enumerate(numbers.labels):
        box = tuple(label.at["box_px"])
        members.setdefault(box, {"x": [], "y": []})[label.at["axis"]].append(k)
    whole = {box: axes for box, axes in members.items() if axes["x"] and axes["y"]}
    places = np.array([((box[0] + box[2]) / 2, (box[1] + box[3]) / 2) for box in whole]).reshape(-1, 2)
    before_px, after_px = (
        np.array(
            [[_mean(moved_px, numbers.sigma, axes[axis]) for axis in "xy"] for axes in whole.values()]
        ).reshape(-1, 2)
        for moved_px in (numbers.z_before * numbers.sigma, numbers.z_after * numbers.sigma)
    )
    size = max(box[2] for box in members), max(box[3] for box in members)
    return Displacements(title, places, before_px, after_px, size)


def _mean(values: NDArray[np.float64], sigma: NDArray[np.float64], kept: list[int]) -> float:
    return float(np.average(values[kept], weights=1 / sigma[kept] ** 2))


def of_boards(problem: Problem, numbers: Numbers) -> list[Displacements]:
    boards = [e for e in problem.evidence if isinstance(e, BoardEvidence)]
    fields = []
    for moved_px in (numbers.z_before * numbers.sigma, numbers.z_after * numbers.sigma):
        start, parts = 0, []
        for board in boards:
            stop = start + 2 * len(board.corners_px)
            parts.append(moved_px[start:stop].reshape(2, -1).T)  # all x of a view stand before all y
            start = stop
        fields.append(np.concatenate(parts))
    geometry = boards[0].capture.geometry
    places = np.concatenate([board.corners_px for board in boards])
    return [Displacements("", places, fields[0], fields[1], (geometry.width_px, geometry.height_px))]


def arrows(
    name: str, fields: Sequence[Displacements], *, before: str, after: str | None, narrow: bool = False
) -> str:
    """SVG of a row per field: its arrows before and after, all on one scale; below each other if narrow."""
    lengths = np.concatenate([np.hypot(*field.before_px.T) for field in fields])
    longest = max(float(np.percentile(lengths, 97)), 1e-6)
    width, height = fields[0].size_px
    count = max(len(field.places_px) for field in fields)
    factor = width * float(np.clip(0.75 / np.sqrt(count), 0.04, 0.1)) / longest
    each = 1 if after is None else 2
    thin = 0.0042 if count < 100 else 0.0024

    def paint(figure: Figure) -> None:
        shape = (len(fields) * each, 1) if narrow else (len(fields), each)
        panels = figure.subplots(*shape, squeeze=False).reshape(len(fields), each)
        for row, field in zip(panels, fields, strict=True):
            drawn = [(before, field.before_px, BEFORE), (after or "", field.after_px, AFTER)]
            for axes, (title, moved_px, colour) in zip(row, drawn, strict=False):
                axes.quiver(
                    *field.places_px.T, *(factor * moved_px).T, angles="xy", scale_units="xy", scale=1,
                    color=colour, width=thin, headwidth=4.5, headlength=5, minlength=0.4,
                )  # fmt: skip
                axes.plot(*field.places_px.T, ".", color=RULE, markersize=2.5, zorder=0)
                axes.set(xlim=(0, width), ylim=(height, 0), aspect="equal", xticks=[], yticks=[])
                rms = number(float(np.sqrt(np.mean(moved_px**2) * 2)), 2)
                axes.set_title(f"{field.title} {title}: {rms} px rms".strip())
                axes.spines[:].set(visible=True, color=RULE)
        _scale(panels[-1, -1], width, height, factor, _round_length(longest))

    size_in = (9.2 if after is not None else 5.0, (0.4 + 4.5 * height / width) * len(fields))
    if narrow:
        name, size_in = f"{name}-narrow", (NARROW_IN, (0.4 + 4.2 * height / width) * len(fields) * each)
    description = f"Displacements over the image, up to {number(float(lengths.max()), 2)} px before."
    return draw(name, size_in, description, paint)


def _scale(axes: Axes, width: int, height: int, factor: float, length_px: float) -> None:
    axes.plot([0.03 * width, 0.03 * width + factor * length_px], [0.965 * height] * 2, color=MUTED)
    text = f"{number(length_px)} px, drawn {number(factor, 2)} times as long"
    axes.text(0.03 * width, 0.945 * height, text, color=MUTED, fontsize=8)


def _round_length(value: float) -> float:
    """The largest of 1, 2, 5 times a power of ten that is not above `value`."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(max(m for m in (1, 2, 5) if m * power <= value * 1.0001) * power)
