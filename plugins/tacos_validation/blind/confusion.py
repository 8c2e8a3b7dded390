"""Confusion of effects: a matrix, and for phones a bar for each effect."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from tacos_report.figures.canvas import NARROW_IN, draw, name_rows
from tacos_report.page import Drawing, in_both_widths
from tacos_report.palette import INK, MUTED, PAPER, RULE, camera_colour
from tacos_validation.blind.cases import Case

OTHERWISE = ("no_gap", "unknown", "partly_explained", "error")
"""Answers that name no effect."""

Confusion = Mapping[str, Counter[str]]
"""Of each withheld effect, how often each answer came first."""


def confusions(cases: Sequence[Case]) -> list[Drawing]:
    return [
        in_both_widths(
            partial(confusion, title, found),
            f"{title.capitalize()}: numbers are cases of all severities.",
        )
        for title, chosen in (
            ("charts", [c for c in cases if c.tier == "T1" and c.captures != "natural"]),
            ("natural scenes alone", [c for c in cases if c.tier == "T1" and c.captures == "natural"]),
            ("independent makers", [c for c in cases if c.tier == "T4"]),
            ("beside nuisances", [c for c in cases if c.tier == "T7" and c.effects]),
        )
        if (found := counted(chosen))
    ]


def counted(cases: Sequence[Case]) -> Confusion:
    found: dict[str, Counter[str]] = {}
    for case in sorted(cases, key=lambda case: case.effects[0]):
        found.setdefault(case.effects[0], Counter())[case.first] += 1
    return found


def confusion(title: str, found: Confusion, *, narrow: bool = False) -> str:
    """SVG of withheld effects against those named first; a bar for each withheld effect if narrow."""
    described = f"Withheld effects against those named, {title}."
    if narrow:
        size_in = (NARROW_IN, 0.5 + 0.44 * len(found))
        return draw(f"confusion-{title}-narrow", size_in, described, partial(_bars, title, found))
    return draw(
        f"confusion-{title}", (9.2, 2.6 + 0.19 * len(found)), described, partial(_matrix, title, found)
    )


def _matrix(title: str, found: Confusion, figure: Figure) -> None:
    rows = list(found)
    answers = {answer for counts in found.values() for answer in counts}
    columns = sorted({*rows, *answers} - set(OTHERWISE))
    columns += [name for name in OTHERWISE if name in answers]
    counts = np.array([[found[row][column] for column in columns] for row in rows])
    shares = counts / counts.sum(axis=1, keepdims=True)
    axes = figure.add_subplot()
    scale = LinearSegmentedColormap.from_list("share", [PAPER, camera_colour(1)])
    axes.pcolormesh(shares, cmap=scale, vmin=0, vmax=1, edgecolors=PAPER, linewidth=0.5)
    for row, column in zip(*np.nonzero(counts), strict=True):
        axes.text(
            column + 0.5, row + 0.5, f"{counts[row, column]:d}", ha="center", va="center", fontsize=7,
            color=PAPER if shares[row, column] > 0.5 else INK,
        )  # fmt: skip
    axes.set_xticks(
        np.arange(len(columns)) + 0.5, [_words(name) for name in columns], rotation=90, fontsize=7
    )
    axes.set_yticks(np.arange(len(rows)) + 0.5, rows, fontsize=7)
    axes.invert_yaxis()
    axes.set_xlabel("named first")
    axes.set_ylabel("withheld")
    axes.set_title(title)
    axes.tick_params(length=0)


def _bars(title: str, found: Confusion, figure: Figure) -> None:
    axes = figure.add_subplot()
    shares = [counts[effect] / counts.total() for effect, counts in found.items()]
    axes.barh(range(len(found)), 1.0, color=RULE, alpha=0.35, height=0.3)
    axes.barh(range(len(found)), shares, color=camera_colour(1), height=0.3)
    for label in name_rows(axes, [_told(*item) for item in found.items()], narrow=True):
        label.set(fontsize=8.5)
    axes.set(xlim=(0, 1), ylim=(len(found) - 0.5, -0.9), xticks=[])
    axes.set_title(f"{title}: share named first", color=MUTED)
    axes.spines[:].set_visible(False)


def _told(effect: str, counts: Counter[str]) -> str:
    """One withheld effect and its answers.

    >>> _told("prnu", Counter(prnu=5, unknown=2, dsnu=1))
    'prnu: 5 of 8, else unknown 2, dsnu 1'
    """
    others = ", ".join(f"{_words(name)} {count}" for name, count in counts.most_common() if name != effect)
    return f"{effect}: {counts[effect]} of {counts.total()}{f', else {others}' if others else ''}"


def _words(answer: str) -> str:
    return answer.replace("_", " ")
