"""Achievements of the variants of a study, and their differences seed by seed."""

from __future__ import annotations

import math
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

FITNESS = "fitness"


@dataclass(frozen=True, eq=False)
class StudyOutcome:
    """A study that was run. `scores`: scores and fitness of the designed camera on unseen scenes."""

    variant: str
    seed: int
    scores: Mapping[str, float]
    camera: Mapping[str, Any]
    images: int
    seconds: float


@dataclass(frozen=True)
class Spread:
    """A mean over seeds with its standard error, which one seed alone does not have."""

    mean: float
    standard_error: float | None
    seeds: int


def spread(values: Sequence[float]) -> Spread:
    error = statistics.stdev(values) / math.sqrt(len(values)) if len(values) > 1 else None
    return Spread(statistics.fmean(values), error, len(values))


@dataclass(frozen=True)
class VariantDifference:
    """A variant against the reference on one score, each seed against its own twin."""

    variant: str
    score: str
    better: int  # seeds with the higher score
    by: Spread


def scores_of(outcomes: Sequence[StudyOutcome]) -> list[str]:
    common = [name for name in outcomes[0].scores if all(name in each.scores for each in outcomes)]
    return sorted(common, key=lambda name: name != FITNESS)


def difference(
    outcomes: Sequence[StudyOutcome], variant: str, reference: str, score: str
) -> VariantDifference:
    """The difference of a variant to the reference, over the seeds both were run with."""
    of = {
        name: {o.seed: o.scores[score] for o in outcomes if o.variant == name}
        for name in (variant, reference)
    }
    by = [of[variant][seed] - of[reference][seed] for seed in of[variant] if seed in of[reference]]
    return VariantDifference(variant, score, sum(each > 0 for each in by), spread(by))
