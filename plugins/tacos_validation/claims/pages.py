"""The report of claims: a row each, with verdict and figures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from tacos_report.page import Page, Section, Table, Warnings
from tacos_report.quantities import duration, number
from tacos_validation.claims.settings import ClaimsConfig
from tacos_validation.claims.verdicts import DOES_NOT, HOLDS, IMAGES, UNDECIDED, ClaimFound, Contrast
from tacos_validation.harness import csv_text


@dataclass(frozen=True, eq=False)
class ClaimsOutcome:
    """Everything the report tells."""

    config: ClaimsConfig
    found: tuple[ClaimFound, ...]
    studies: int
    images: int
    seconds: float
    notes: tuple[str, ...]

    def as_data(self) -> dict[str, Any]:
        return {
            "source": self.config.source,
            "claims": [asdict(each) for each in self.found],
            "studies": self.studies,
            "frames_rendered": self.images,
            "comparison_notes": list(self.notes),
        }


def page(outcome: ClaimsOutcome) -> Page:
    config = outcome.config
    rows = tuple(
        (each.says, each.scoring, each.verdict, *_figures(each, config), str(_seeds(each)))
        for each in outcome.found
    )
    heads = ("Claim", "Scoring", "Verdict", "Compared with", f"Difference [{config.confidence:.0%}]", "Seeds")
    source = f"The claims are those of {config.source}. " if config.source else ""
    notes = (Section("Notes", (Warnings("What to know", outcome.notes),)),) if outcome.notes else ()
    return Page(
        eyebrow="Claims",
        title=summary(outcome.found).splitlines()[0],
        lead=(
            f"{outcome.studies} studies with {outcome.images} images, {duration(outcome.seconds)} in all. "
            f"{source}Studies of a seed see the same worlds and are tested on the same unseen scenes, so "
            "differences are taken seed by seed, with intervals by Student's t. A claim holds if the "
            "interval supports it over every rival."
        ),
        sections=(Section("Claims", (Table(heads, rows),)), *notes),
    )


def summary(found: Sequence[ClaimFound]) -> str:
    counts = [
        f"{sum(each.verdict == verdict for each in found)} {word}"
        for verdict, word in ((HOLDS, "hold"), (DOES_NOT, "do not"), (UNDECIDED, "are undecided"))
    ]
    lines = [f"{each.claim}, {each.scoring}: {each.verdict}" for each in found]
    return "\n".join([f"Of {len(found)} claims {', '.join(counts)}", *lines])


def table_csv(outcome: ClaimsOutcome) -> str:
    rows = [
        (each.claim, each.scoring, each.verdict, one.over, one.mean, one.low, one.high, one.seeds)
        for each in outcome.found
        for one in each.contrasts
    ]
    return csv_text(("claim", "scoring", "verdict", "over", "difference", "low", "high", "seeds"), rows)


def _figures(found: ClaimFound, config: ClaimsConfig) -> tuple[str, str]:
    if not found.contrasts:
        return "no figures in two seeds", ""
    value = config.claims[found.claim].value
    return (
        "; ".join(each.over for each in found.contrasts),
        "; ".join(_shown(each, value) for each in found.contrasts),
    )


def _shown(each: Contrast, value: str) -> str:
    figures = [each.mean, each.low, each.high]
    if value == IMAGES:
        mean, low, high = (f"{number(2**figure, 3)} times" for figure in figures)
        return f"{mean} [{low}, {high}]"
    mean, low, high = (f"{'+' if figure > 0 else ''}{number(figure, 3)}" for figure in figures)
    return f"{mean} [{low}, {high}]"


def _seeds(found: ClaimFound) -> int:
    return min((each.seeds for each in found.contrasts), default=0)
