"""The report of studies side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

from matplotlib.figure import Figure

from tacos_report.figures.canvas import NARROW_IN, draw, light_grid
from tacos_report.page import Page, Section, Table, in_both_widths
from tacos_report.palette import MUTED, camera_colour
from tacos_report.quantities import number, words
from tacos_validation.harness import csv_text
from tacos_validation.studies_compared.pairs import (
    FITNESS,
    Spread,
    StudyOutcome,
    VariantDifference,
    difference,
    scores_of,
    spread,
)

MOST_DRAWN = 5
"""Scores that stand beside one another in a drawing and can still be read."""


@dataclass(frozen=True, eq=False)
class StudiesComparison:
    """Everything the report tells."""

    study: str
    reference: str
    outcomes: tuple[StudyOutcome, ...]
    counted: tuple[str, ...]
    """Scores that a fitness takes."""

    @property
    def scores(self) -> list[str]:
        known = scores_of(self.outcomes)
        return list(dict.fromkeys([FITNESS, *(name for name in self.counted if name in known), *known]))

    @property
    def headline_scores(self) -> list[str]:
        """The fitness and what it takes."""
        return [name for name in self.scores if name in (FITNESS, *self.counted)]

    @property
    def variants(self) -> list[str]:
        return list(dict.fromkeys(outcome.variant for outcome in self.outcomes))

    @property
    def differences(self) -> list[VariantDifference]:
        """Of every other variant and score to the reference."""
        return [
            difference(self.outcomes, variant, self.reference, score)
            for variant in self.variants
            if variant != self.reference
            for score in self.scores
        ]

    def of(self, variant: str) -> list[StudyOutcome]:
        return [outcome for outcome in self.outcomes if outcome.variant == variant]

    def as_data(self) -> dict[str, Any]:
        return {
            "study": self.study,
            "reference": self.reference,
            "studies": [asdict(outcome) for outcome in self.outcomes],
            "differences": [asdict(each) for each in self.differences],
        }


def summary(compared: StudiesComparison) -> str:
    return "\n".join(_sentence(each) for each in compared.differences if each.score == FITNESS)


def _sentence(found: VariantDifference) -> str:
    return (
        f"{found.variant} is better in {found.better} of {found.by.seeds} seeds, "
        f"by {_plus_minus(found.by, sign=True)} in fitness on unseen scenes"
    )


def page(compared: StudiesComparison) -> Page:
    seeds = sorted({outcome.seed for outcome in compared.outcomes})
    hours = sum(outcome.seconds for outcome in compared.outcomes) / 3600
    drawn = partial(_by_variant, compared)
    return Page(
        eyebrow="Studies compared",
        title=summary(compared).replace("\n", "; "),
        lead=(
            f"The study {compared.study} as {', '.join(compared.variants)}, each with seeds "
            f"{', '.join(map(str, seeds))}: {len(compared.outcomes)} studies, {hours:.1f} hours. Studies "
            f"of a seed see the same worlds and are tested on the same unseen scenes, so differences are "
            f"taken seed by seed. ± is the standard error over seeds."
        ),
        sections=(
            Section("On unseen scenes", (in_both_widths(drawn, "A line for each seed."), _means(compared))),
            Section(f"Differences to {compared.reference}", (_differences(compared),)),
            Section("Every study", (_every(compared),)),
        ),
    )


def _by_variant(compared: StudiesComparison, *, narrow: bool = False) -> str:
    """SVG of a panel per score, with a line for each seed over the variants; below each other if narrow."""
    scores = compared.headline_scores[:MOST_DRAWN]
    variants = compared.variants

    def paint(figure: Figure) -> None:
        shape = (len(scores), 1) if narrow else (1, len(scores))
        for score, axes in zip(scores, figure.subplots(*shape, squeeze=False).ravel(), strict=True):
            for i, seed in enumerate(sorted({outcome.seed for outcome in compared.outcomes})):
                found = {o.variant: o.scores[score] for o in compared.outcomes if o.seed == seed}
                at = [variants.index(name) for name in variants if name in found]
                axes.plot(
                    at, [found[variants[x]] for x in at], "o-", color=camera_colour(i), label=f"seed {seed}"
                )
            axes.set_xticks(range(len(variants)), variants)
            axes.margins(x=0.2, y=0.15)
            axes.set_title(words(score))
            light_grid(axes, "y")
        handles, labels = figure.axes[0].get_legend_handles_labels()
        ncols = min(len(handles), 4 if narrow else 9)
        figure.legend(handles, labels, loc="outside lower center", ncols=ncols, labelcolor=MUTED)

    described = f"Scores of {', '.join(variants)} on unseen scenes, a line for each seed."
    if narrow:
        return draw("studies-narrow", (NARROW_IN, 0.6 + 2.1 * len(scores)), described, paint)
    return draw("studies", (9.2, 3.6), described, paint)


def _means(compared: StudiesComparison) -> Table:
    scores = compared.headline_scores
    rows = tuple(
        (variant, *(_plus_minus(spread([o.scores[score] for o in compared.of(variant)])) for score in scores))
        for variant in compared.variants
    )
    return Table(("Variant", *map(words, scores)), rows, "Means over seeds.")


def _differences(compared: StudiesComparison) -> Table:
    rows = tuple(
        (
            each.variant,
            words(each.score),
            _plus_minus(each.by, sign=True),
            f"{each.better} of {each.by.seeds}",
        )
        for each in compared.differences
    )
    return Table(("Variant", "Score", "Difference", "Seeds in which it is higher"), rows)


def _every(compared: StudiesComparison) -> Table:
    scores = compared.headline_scores
    rows = tuple(
        (
            outcome.variant,
            str(outcome.seed),
            *(number(outcome.scores[score]) for score in scores),
            _camera(outcome),
            f"{outcome.seconds / 60:.0f} min",
        )
        for outcome in compared.outcomes
    )
    return Table(("Variant", "Seed", *map(words, scores), "Designed camera", "Time"), rows)


def _camera(outcome: StudyOutcome) -> str:
    shown = (
        f"{name} {value.get('name', '')}" if isinstance(value, dict) else f"{name} {_short(value)}"
        for name, value in outcome.camera.items()
    )
    return ", ".join(shown)


def _short(value: Any) -> str:
    return number(value) if isinstance(value, int | float) else str(value)


def _plus_minus(found: Spread, *, sign: bool = False) -> str:
    mean = f"{found.mean:+.3f}" if sign else f"{found.mean:.3f}"
    return mean if found.standard_error is None else f"{mean} ± {found.standard_error:.3f}"


def table_csv(outcomes: Sequence[StudyOutcome]) -> str:
    scores = scores_of(outcomes)
    return csv_text(
        ("variant", "seed", *scores, "images", "seconds"),
        (
            (o.variant, o.seed, *(o.scores[name] for name in scores), o.images, f"{o.seconds:.0f}")
            for o in outcomes
        ),
    )
