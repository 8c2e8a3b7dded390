"""The report of a validation at a task."""

from __future__ import annotations

from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from tacos_framework import FrameBatch
from tacos_framework.camera import display_image
from tacos_report.figures.canvas import NARROW_IN, draw, light_grid
from tacos_report.page import (
    Heading,
    Page,
    PagePicture,
    Paragraph,
    Section,
    SideBySide,
    Table,
    image_uri,
    in_both_widths,
)
from tacos_report.palette import INK, MUTED, camera_colour
from tacos_validation.task_validation.acquisition import Taken
from tacos_validation.task_validation.agreement import INTERVAL
from tacos_validation.task_validation.findings import ValidationFindings

_MARGIN = 0.15
"""Of the target's extent, shown around it."""

_WIDEST_PX = 700


def summary(findings: ValidationFindings) -> str:
    lines = [title(findings)]
    for setting, words in enumerate(findings.exposures):
        order = " > ".join(findings.titles[i] for i in findings.order(findings.reference, setting))
        lines.append(
            f"{words}: reference {order}; rank correlation overall {findings.overall(setting).tau}, "
            f"at a place {findings.per_pair(setting)}, of the scores {findings.levels(setting)}"
        )
    every, floor = findings.everything, findings.everything_floor
    lines.append(f"every camera under every exposure: {every.tau}; the reference with itself {floor.tau}")
    return "\n".join(lines)


def title(findings: ValidationFindings) -> str:
    settings = range(len(findings.exposures))
    alike = sum(findings.same_order(setting) for setting in settings)
    if alike == len(settings):
        where = "" if alike == 1 else f" under all {alike} exposures"
        return f"Both simulators rank the cameras alike{where}"
    return f"The simulators rank the cameras alike under {alike} of {len(settings)} exposures"


def page(simulator: str, reference: str, findings: ValidationFindings) -> Page:
    seeds = findings.scores(findings.reference).shape[1]
    every, floor = findings.everything, findings.everything_floor
    return Page(
        eyebrow="Task validation",
        title=title(findings),
        lead=(
            f"{len(findings.cameras)} cameras before one target, at {findings.places} places along a line: "
            f"in {simulator}, and in {reference}, which stands for reality; {seeds} frames of every place "
            f"with independent noise. Intervals hold 95 % of the seeds. Every camera under every exposure, "
            f"ranked all against all: rank correlation {every.tau} (Kendall), and {floor.tau} for the "
            f"reference with itself under other noise, which is as much as noise allows."
        ),
        sections=[
            Section("Frames side by side", tuple(_frames(findings, simulator, reference))),
            *(_section(findings, setting) for setting in range(len(findings.exposures))),
            _limits(findings),
        ],
    )


def _section(findings: ValidationFindings, setting: int) -> Section:
    better, worse, apart = findings.nearest(setting)
    overall = findings.overall(setting)
    return Section(
        f"At {findings.exposures[setting]}",
        (
            in_both_widths(
                partial(_by_pair, findings, setting),
                "Between each place and the next. Lines are means over the noise, bands hold 95 % of "
                "the seeds.",
            ),
            Paragraph(
                f"Ranked by the mean over all places, both agree under {overall.same:.0%} of the seeds: rank "
                f"correlation {overall.tau}. Ranked at each pair of places by itself: "
                f"{findings.per_pair(setting)}. The scores themselves, over all cameras and places: "
                f"{findings.levels(setting)} (Spearman). Hardest to tell apart in the reference are "
                f"{findings.titles[better]} and {findings.titles[worse]}, {_apart(apart)}."
            ),
            _levels(findings, setting),
            _pairs(findings, setting),
        ),
    )


def _apart(deviations: float) -> str:
    if np.isinf(deviations):
        return "which noise never swaps"
    return f"{deviations:.1f} standard deviations apart from seed to seed"


def _by_pair(findings: ValidationFindings, setting: int, *, narrow: bool = False) -> str:
    """SVG of a panel per score, with two lines for each camera; panels stand below each other if narrow."""
    names = list(findings.reference[0].scores)

    def paint(figure: Figure) -> None:
        shape = (len(names), 1) if narrow else (1, len(names))
        for axes, name in zip(figure.subplots(*shape, squeeze=False).ravel(), names, strict=True):
            _paint(axes, findings, setting, name)
            axes.set_title(name.replace("_", " "))
        handles = [
            Line2D([], [], color=camera_colour(i + 1), linewidth=2, label=words)
            for i, words in enumerate(findings.titles)
        ]
        handles += [
            Line2D([], [], color=INK, linewidth=2, label="simulator"),
            Line2D([], [], color=INK, linewidth=2, linestyle="--", label="reference"),
        ]
        ncols = 2 if narrow else len(handles)
        figure.legend(handles=handles, loc="outside lower center", ncols=ncols, labelcolor=MUTED)

    described = f"{', '.join(names)} at each pair of places, for {', '.join(findings.titles)}."
    if narrow:
        size_in = (NARROW_IN, 0.6 + 2.4 * len(names) + 0.12 * len(findings.titles))
        return draw(f"task-{setting}-narrow", size_in, described, paint)
    return draw(f"task-{setting}", (9.2, 3.8), described, paint)


def _paint(axes: Axes, findings: ValidationFindings, setting: int, name: str) -> None:
    pairs = np.arange(1, findings.places)
    for taken, style in ((findings.simulated, "-"), (findings.reference, "--")):
        scores = findings.scores(taken, name)[setting]
        for camera in range(len(findings.cameras)):
            colour = camera_colour(camera + 1)
            low, high = np.percentile(scores[:, camera], INTERVAL, axis=0)
            axes.fill_between(pairs, low, high, color=colour, alpha=0.15, linewidth=0)
            axes.plot(pairs, scores[:, camera].mean(axis=0), color=colour, linewidth=1.8, linestyle=style)
    axes.set_xlabel("from this place to the next")
    axes.set_xticks(pairs)
    axes.set_ylim(bottom=0)
    light_grid(axes, "y")


def _levels(findings: ValidationFindings, setting: int) -> Table:
    ranks = [
        {camera: place + 1 for place, camera in enumerate(findings.order(taken, setting))}
        for taken in (findings.simulated, findings.reference)
    ]
    names = list(findings.reference[0].scores)
    rows = tuple(
        (
            words,
            f"{findings.reference[i].on_target_px.mean():,.0f}",
            *(
                str(findings.level(taken, setting, i, name))
                for name in names
                for taken in (findings.simulated, findings.reference)
            ),
            f"{ranks[0][i]}",
            f"{ranks[1][i]}",
        )
        for i, words in enumerate(findings.titles)
    )
    heads = (
        "Camera",
        "Pixels on target",
        *(f"{name.replace('_', ' ')}, {who}" for name in names for who in ("simulator", "reference")),
        "Rank, simulator",
        "Rank, reference",
    )
    return Table(heads, rows, f"Means over all places. Ranked by {findings.score.replace('_', ' ')}.")


def _pairs(findings: ValidationFindings, setting: int) -> Table:
    rows = tuple(
        (
            f"{pair + 1} to {pair + 2}",
            str((found := findings.at_pair(setting, pair)).tau),
            f"{found.same:.0%}",
            str((floor := findings.floor_at_pair(setting, pair)).tau),
            f"{floor.same:.0%}",
        )
        for pair in range(findings.places - 1)
    )
    heads = (
        "Places", "Rank correlation", "Same order", "Reference with itself", "Same order, with itself",
    )  # fmt: skip
    caption = (
        "Kendall's tau of the simulator's ranking with the reference's at each pair of places, and the share "
        "of seeds under which the orders are equal; beside it the reference under one noise and another."
    )
    return Table(heads, rows, caption)


def _frames(findings: ValidationFindings, simulator: str, reference: str) -> list[Heading | SideBySide]:
    blocks: list[Heading | SideBySide] = []
    for camera, words in enumerate(findings.titles):
        blocks.append(Heading(words))
        for setting in sorted({0, len(findings.exposures) - 1}):
            blocks.append(
                SideBySide(
                    tuple(
                        _frame(taken[camera], setting, f"{who} at {findings.exposures[setting]}")
                        for taken, who in ((findings.simulated, simulator), (findings.reference, reference))
                    )
                )
            )
    return blocks


def _frame(taken: Taken, setting: int, caption: str) -> PagePicture:
    batch = taken.samples[setting]
    image = around_target(batch)
    every = -(-image.shape[1] // _WIDEST_PX)
    shown = np.maximum(image[::every, ::every], batch.black_level_dn)
    display = display_image(shown, batch.black_level_dn, batch.white_level_dn, coded=batch.coded)
    colour = np.repeat(display, 3, axis=-1) if display.shape[-1] == 1 else display
    return PagePicture(image_uri(colour), caption, enlarged=True)


def around_target(batch: FrameBatch) -> NDArray[np.uint8] | NDArray[np.uint16]:
    """(H, W, C) the first frame, cut to the target and a margin."""
    rows, columns = np.nonzero(batch.capture.views[0].object_id[0])
    image = batch.images[0][0]
    if not len(rows):
        return image
    margin = int(_MARGIN * max(np.ptp(rows), np.ptp(columns))) + 1
    return image[
        max(rows.min() - margin, 0) : rows.max() + margin + 1,
        max(columns.min() - margin, 0) : columns.max() + margin + 1,
    ]


def _limits(findings: ValidationFindings) -> Section:
    ratios = ", ".join(
        f"{words} {ours.luminance_cd_m2 / theirs.luminance_cd_m2:.3f}"
        for words, ours, theirs in zip(findings.titles, findings.simulated, findings.reference, strict=True)
        if theirs.luminance_cd_m2
    )
    return Section(
        "What this shows, and what not",
        (
            Paragraph(
                "Shadows, light between surfaces, edges and the filtering of fine detail are traced in the "
                "reference and approximated in the simulator; scene, lens and sensor model are the same in "
                "both. Agreement says that the approximations of light do not change which camera is "
                "better. It says nothing of lenses, printing or real sensors, which need real captures."
            ),
            Paragraph(
                "A path tracer adds its own noise, which lies under the sensor's in every frame of the "
                "reference: it costs matches there, as printing did in the paper."
            ),
            Paragraph(f"Mean luminance of the target, simulator over reference: {ratios}."),
        ),
    )
