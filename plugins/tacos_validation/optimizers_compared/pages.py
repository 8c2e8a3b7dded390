"""The report of a comparison."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial

import numpy as np
from matplotlib.figure import Figure

from tacos_report.figures.canvas import NARROW_IN, draw, light_grid, logarithmic_height
from tacos_report.page import Page, Paragraph, Section, Table, Warnings, in_both_widths
from tacos_report.palette import MUTED, camera_colour
from tacos_validation.optimizers_compared.outcome import Comparison
from tacos_validation.optimizers_compared.problem import values_text
from tacos_validation.optimizers_compared.standings import Quartiles, Ratio, Standing

COLOURS = 7
"""Colours there are; the lines beyond are dashed."""


def summary(comparison: Comparison) -> str:
    lines = [_finding(comparison)]
    for each in comparison.standings:
        last = max(each.regret)
        lines.append(
            f"{each.optimizer}: target after {_images(each.images)} images, reached by {each.reached:.0%}; "
            f"regret {_regret(each.regret[last])} after {last}"
        )
    return "\n".join(lines)


def page(comparison: Comparison) -> Page:
    runs = max(each.runs for each in comparison.standings)
    curve = partial(_regret_curve, comparison)
    caption = "Bands are quartiles. Dashed: the target. Dotted: a tenth of its images."
    notes = (Section("Notes", (Warnings("What to know", comparison.notes),)),) if comparison.notes else ()
    return Page(
        eyebrow="Optimizers compared",
        title=_finding(comparison),
        lead=(
            f"{len(comparison.standings)} optimizers on the problem {comparison.problem}, {runs} runs each. "
            f"What counts is images rendered: what a run has had before and what breaks a constraint costs "
            f"nothing. Regret is how far what a run recommends lies below the best camera known on "
            f"{comparison.held_out} scenes that no run sees, {comparison.best_known:.3f}. Figures are "
            f"medians over runs, with quartiles in brackets."
        ),
        sections=(
            *notes,
            Section("Regret against images", (in_both_widths(curve, caption), _regrets(comparison))),
            Section("Images to the target", (_standings(comparison), *_explained(comparison))),
        ),
    )


def _explained(comparison: Comparison) -> tuple[Paragraph, ...]:
    return (
        Paragraph(
            f"The target is the median quality of {comparison.target_of} on the held-out scenes: fitness "
            f"{comparison.target:.3f}, a regret of {comparison.best_known - comparison.target:.3f}, for "
            f"which its runs had rendered {comparison.target_images:.0f} images. A run has reached it at "
            f"the first checkpoint at which what it recommends is as good."
        ),
        Paragraph(
            f"The best camera known there: {values_text(comparison.best_camera)}. Candidates are points of a "
            f"grid, so that all runs could share {comparison.rendered} images; each is charged as if it had "
            f"been alone."
        ),
    )


def _finding(comparison: Comparison) -> str:
    reached = [each for each in comparison.standings if math.isfinite(each.images.median)]
    first = comparison.target_of.partition(" after ")[0]
    others = [each for each in reached if each.optimizer != first]
    if not others:
        return f"No other optimizer reaches the quality of {comparison.target_of}"
    best = others[0]
    share = best.images.median / comparison.target_images
    return (
        f"{best.optimizer} reaches the quality of {comparison.target_of} with {share:.0%} of its images: "
        f"{best.images.median:.0f} of {comparison.target_images:.0f}"
    )


def _regret_curve(comparison: Comparison, *, narrow: bool = False) -> str:
    names = list(comparison.runs)
    finite = [
        figure
        for each in comparison.standings
        for regret in each.regret.values()
        for figure in (regret.low, regret.median, regret.high)
        if math.isfinite(figure) and figure > 0
    ]
    floor = min(finite, default=1e-3) / 2

    def paint(figure: Figure) -> None:
        axes = figure.add_subplot()
        for each in sorted(comparison.standings, key=lambda each: names.index(each.optimizer)):
            place = names.index(each.optimizer)
            at = [a for a, regret in each.regret.items() if math.isfinite(regret.median)]
            low, middle, high = (
                np.maximum([getattr(each.regret[a], part) for a in at], floor)
                for part in ("low", "median", "high")
            )
            colour, dashes = camera_colour(place), "-" if place < COLOURS else "--"
            whole = np.where(np.isfinite(high), high, middle)
            axes.fill_between(at, low, whole, color=colour, alpha=0.1, linewidth=0)
            axes.plot(at, middle, dashes, color=colour, linewidth=2, marker="o", ms=3.5, label=each.optimizer)
        goal = comparison.best_known - comparison.target
        if math.isfinite(goal):
            axes.axhline(max(goal, floor), color=MUTED, linewidth=1, linestyle="--")
        axes.axvline(comparison.target_images / 10, color=MUTED, linewidth=1, linestyle=":")
        logarithmic_height(axes)
        axes.set_xscale("log")
        shown = sorted({at for each in comparison.standings for at in each.regret})
        axes.set_xticks(shown, [str(at) for at in shown], rotation=90 if narrow else 0)
        axes.minorticks_off()
        axes.set_xlabel("images rendered")
        axes.set_ylabel("regret on the held-out scenes")
        light_grid(axes, "y")
        if narrow:
            figure.legend(loc="outside lower left", ncols=2, labelcolor=MUTED)
        else:
            axes.legend(ncols=4, labelcolor=MUTED)

    described = f"Median regret of {', '.join(names)} against images rendered."
    if narrow:
        size_in = (NARROW_IN, 3.8 + 0.1 * len(names))
        return draw("regret-narrow", size_in, described, paint)
    return draw("regret", (9.2, 4.6), described, paint)


def _regrets(comparison: Comparison) -> Table:
    checkpoints = sorted({at for each in comparison.standings for at in each.regret})
    rows = tuple(
        (
            each.optimizer,
            *(_regret(each.regret[at]) if at in each.regret else "not run" for at in checkpoints),
        )
        for each in comparison.standings
    )
    return Table(("Regret after", *map(str, checkpoints)), rows, "Medians over runs, quartiles in brackets.")


def _standings(comparison: Comparison) -> Table:
    others = list(comparison.standings[0].ratios)
    rows = tuple(_row(each, others) for each in comparison.standings)
    heads = (
        "Optimizer",
        "Images to the target",
        "Reached by",
        *(f"Times fewer than {other}" for other in others),
        "Time to propose",
    )
    return Table(heads, rows, "A time to propose is per candidate asked for, without its simulation.")


def _row(each: Standing, others: Sequence[str]) -> tuple[str, ...]:
    return (
        each.optimizer,
        _images(each.images),
        f"{each.reached:.0%}",
        *(_times(each.ratios[other]) for other in others),
        f"{each.thought_ms:.1f} ms",
    )


def _times(ratio: Ratio) -> str:
    if ratio.value is None:
        return "not reached"
    return f"{'at least ' if ratio.at_least else ''}{ratio.value:.1f}"


def _images(found: Quartiles) -> str:
    return _interval(found, 0, "never")


def _regret(found: Quartiles) -> str:
    return _interval(found, 3, "nothing yet")


def _interval(found: Quartiles, digits: int, if_infinite: str) -> str:
    low, median, high = (
        if_infinite if math.isinf(value) else f"{value:.{digits}f}"
        for value in (found.low, found.median, found.high)
    )
    return median if low == median == high else f"{median} [{low}, {high}]"
