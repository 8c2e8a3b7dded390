"""The report of a rank agreement: both orders side by side."""

from __future__ import annotations

from functools import partial
from typing import Any

from matplotlib.figure import Figure

from tacos_report.figures.canvas import NARROW_IN, draw
from tacos_report.page import Block, Page, Paragraph, Section, Table, Warnings, in_both_widths
from tacos_report.palette import INK, MUTED, camera_colour
from tacos_validation.harness import csv_text
from tacos_validation.rank_agreement.outcome import SIZES, RankedLight, RankOutcome


def summary(outcome: RankOutcome) -> str:
    lines = [_finding(outcome)]
    for light in outcome.lights:
        lines.append(f"{light.name}: tau {_tau(light)}, {len(light.ranked)} cameras")
    lines += filter(None, (outcome.of_decided_pairs, outcome.shared))
    return "\n".join([*lines, *(_left_out(row) for light in outcome.lights for row in light.left_out())])


def table_csv(outcome: RankOutcome) -> str:
    heads = ("camera", "light", "quick", "full", "rank_quick", "rank_full")
    return csv_text(heads, ([row[head] for head in heads] for row in outcome.as_data()["table"]))


def page(outcome: RankOutcome) -> Page:
    cost = outcome.cost()
    quick, full = (cost[size] for size in SIZES)
    left_out = tuple(_left_out(row) for light in outcome.lights for row in light.left_out())
    told = (outcome.shared, outcome.of_decided_pairs)
    warned = (*outcome.doubts, *left_out, *outcome.notes)
    return Page(
        eyebrow="Rank agreement",
        title=_finding(outcome),
        lead=(
            f"The same cameras on the same {outcome.scenes} scenes, scored by {outcome.study} as it stands "
            f"and at full size. Kendall's tau-b is 1 where both orders are equal, 0 where they have "
            f"nothing to do with each other, -1 where one is the other reversed; "
            f"in brackets its {outcome.confidence:.0%} interval over draws of scenes."
        ),
        sections=(
            Section("What it does not tell", tuple(map(Paragraph, filter(None, told)))),
            *((Section("Notes", (Warnings("What to know", warned),)),) if warned else ()),
            *(Section(f"By {light.name}", _by_light(light)) for light in outcome.lights),
            Section(
                "What it cost",
                (
                    Paragraph(
                        f"As it stands {quick['images']:.0f} images and {quick['seconds']:.0f} s of one "
                        f"core, at full size {full['images']:.0f} images and {full['seconds']:.0f} s."
                    ),
                ),
            ),
        ),
    )


def _finding(outcome: RankOutcome) -> str:
    if outcome.passes:
        lowest = min(light.agreement.tau or 0.0 for light in outcome.lights)
        return f"{outcome.study} ranks cameras as it does at full size: tau is {lowest:.2f} or more"
    return f"{outcome.study} must not stand for the study at full size: {outcome.doubts[0]}"


def _left_out(row: dict[str, str]) -> str:
    return f"{row['camera']} has no place by {row['light']} ({row['study']}): {row['why']}."


def _tau(light: RankedLight) -> str:
    found = light.agreement
    if found.tau is None:
        return "not defined"
    if found.interval is None:
        return f"{found.tau:.2f}"
    return f"{found.tau:.2f} [{found.interval[0]:.2f}, {found.interval[1]:.2f}]"


def _by_light(light: RankedLight) -> tuple[Block, ...]:
    caption = f"Kendall's tau {_tau(light)}. The best camera stands on top."
    return in_both_widths(partial(_slopes, light), caption), _table(light)


def _slopes(light: RankedLight, *, narrow: bool = False) -> str:
    """A line for each camera from its place in one order to that in the other, equal ones side by side."""
    quick, full = ({name: i for i, name in enumerate(light.order(size), 1)} for size in SIZES)
    equal = light.not_told_apart
    beside = 1.2 if narrow else 0.8

    def paint(figure: Figure) -> None:
        axes = figure.add_subplot()
        for name in light.ranked:
            moved = abs(quick[name] - full[name])
            colour = camera_colour(0) if moved >= 2 else camera_colour(1) if moved else MUTED
            axes.plot(
                [0, 1], [quick[name], full[name]], color=colour, linewidth=1.6, marker="o", markersize=4
            )
            text: dict[str, Any] = {"va": "center", "color": INK, "fontsize": 8 if narrow else 9}
            axes.text(-0.06, quick[name], f"{name}{' (equal)' * (name in equal)}", ha="right", **text)
            axes.text(1.06, full[name], name, ha="left", **text)
        axes.set_xlim(-beside, 1 + beside)
        axes.set_ylim(len(light.ranked) + 0.6, 0.4)
        axes.set_xticks([0, 1], ["as it stands", "at full size"])
        axes.set_yticks([])
        for side in ("left", "bottom"):
            axes.spines[side].set_visible(False)
        axes.tick_params(length=0)

    height = 0.6 + 0.26 * max(len(light.ranked), 2)
    described = f"Places of {len(light.ranked)} cameras in both orders, by {light.name}."
    if narrow:
        return draw(f"places-{light.name}-narrow", (NARROW_IN, height), described, paint)
    return draw(f"places-{light.name}", (7.2, height), described, paint)


def _table(light: RankedLight) -> Table:
    fitness = {size: light.fitness(size) for size in SIZES}
    ranks = {size: light.places(size) for size in SIZES}
    rows = tuple(
        (
            name,
            f"{ranks['quick'][name]:g}",
            f"{ranks['full'][name]:g}",
            f"{fitness['quick'][name]:.3f}",
            f"{fitness['full'][name]:.3f}",
        )
        for name in light.order("full")
    )
    scores = ", ".join(
        f"{score} {'all equal' if tau is None else f'{tau:.2f}'}" for score, tau in light.by_score.items()
    )
    heads = ("Camera", "Place", "Place at full size", "Fitness", "Fitness at full size")
    return Table(heads, rows, f"Tau of each score by itself: {scores or 'none is reported by both'}.")
