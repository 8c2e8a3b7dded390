"""Drawings of the statistics that are significant."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from tacos_gap.answer.findings import Diagnosis
from tacos_gap.captures import RealCapture
from tacos_gap.inference.fit import Fitted
from tacos_gap.inference.problem import Hypothesis, Problem, placed, robust, without
from tacos_gap.report.arrows import arrows, of_boards, of_tiles
from tacos_gap.report.histogram import histogram
from tacos_gap.report.image_map import image_map
from tacos_gap.report.numbers import Numbers
from tacos_gap.report.profiles import profile
from tacos_gap.statistics.views import over, view_of
from tacos_report.page import Drawing, in_both_widths

CODES = frozenset({"code_comb", "clipped", "top_level"})
"""Statistics best seen in a histogram."""

LEAST_SHARE = 0.01
"""Share in the squared gap from which on a statistic is drawn."""

FAR = 5.0
"""Gap of its own from which on it is drawn however small its share: some have few numbers [noise floor]."""

_MAPS = frozenset(
    {"relative_illumination", "displacement", "board_corners", "colour_displacement", "dark_field"}
)
"""Statistics with a place in the image."""


@dataclass(frozen=True, eq=False)
class Artist:
    """Draws statistics of a diagnosis. `captures`: the captures, for histograms."""

    problem: Problem
    captures: Sequence[RealCapture]
    hypothesis: Hypothesis
    seed: int
    before: str = "simulated"
    after: str | None = "with the causes"

    def drawing(self, name: str, numbers: Numbers) -> Drawing:
        view = view_of(numbers.statistic)
        kind = over(label.at for label in numbers.labels)
        caption = f"{view.title}. {view.explained}".rstrip()
        titles: Any = {"before": self.before, "after": self.after}
        if numbers.statistic in CODES and (capture := self._most_different(numbers)) is not None:
            svg = histogram(name, capture, placed(self.hypothesis, capture.id), self.seed, **titles)
            return Drawing(svg, caption)
        if numbers.statistic == "board_corners":
            drawn = partial(arrows, name, of_boards(self.problem, numbers), **titles)
        elif kind == "arrows":
            drawn = partial(arrows, name, of_tiles(numbers), **titles)
        elif kind == "image":
            drawn = partial(image_map, name, numbers, **titles)
        else:
            drawn = partial(profile, name, numbers, kind, **titles)
        if kind == "arrows" or numbers.statistic == "board_corners":
            caption += " Above: the root of the mean square (rms)."
        return in_both_widths(drawn, caption)

    def over_radius(self, name: str, numbers: Numbers) -> Drawing:
        drawn = partial(profile, name, numbers, "radius", before=self.before, after=self.after)
        title = view_of(numbers.statistic).title
        return in_both_widths(drawn, f"{title}, over the distance from the centre.")

    def _most_different(self, numbers: Numbers) -> RealCapture | None:
        label = numbers.labels[int(np.argmax(np.abs(numbers.z_before)))]
        return next((c for c in self.captures if c.id == label.capture and c.expected_dn is not None), None)


def is_wide(numbers: Numbers, *, compared: bool = True) -> bool:
    """True if a drawing takes the whole width: several panels, maps and arrows before and after."""
    kind = over(label.at for label in numbers.labels)
    if numbers.statistic in CODES:
        return False
    if kind in ("image", "arrows"):
        return compared
    panels = {str(label.at.get("channel", "")) for label in numbers.labels}
    return kind == "frequency" or (kind != "places" and len(panels) > 1)


def standing_out(diagnosis: Diagnosis, numbers: Mapping[str, Numbers]) -> list[str]:
    """Statistics that hold more than a little of the gap or are far off, the largest share first.

    Where none does, the two that come nearest to it.
    """
    found = [
        place.statistic
        for place in diagnosis.where
        if place.statistic in numbers
        and (place.share >= LEAST_SHARE or numbers[place.statistic].gap_before >= FAR)
    ]
    return found or sorted(numbers, key=lambda name: -numbers[name].gap_before)[:2]


def mapped(statistics: Iterable[str]) -> str | None:
    """The first statistic that says where in the image the gap lies; None where there is none."""
    return next((name for name in statistics if name in _MAPS), None)


def decisive(problem: Problem, best: Fitted, effect: str) -> tuple[str, Any] | None:
    rest = problem.residual(without(best.hypothesis, effect))
    if rest is None:
        return None
    gained = robust(rest) ** 2 - robust(best.z) ** 2
    sums: dict[str, float] = {}
    for label, gain in zip(problem.labels, gained.tolist(), strict=True):
        sums[label.statistic] = sums.get(label.statistic, 0.0) + gain
    return max(sums, key=lambda name: sums[name]), rest
