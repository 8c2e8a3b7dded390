"""Calibration of answers: does their stated certainty hold?"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from tacos_validation.blind.cases import Case
from tacos_validation.blind.figure import Figure, at_most, interval, middle, share
from tacos_validation.blind.judgement import sureness
from tacos_validation.blind.parameters_found import ParameterFound

BINS = 10

LEVELS = (0.5, 0.68, 0.8, 0.9, 0.95, 0.99)
"""Nominal coverages at which intervals are looked at; those of 90 % are scaled as a Gaussian's."""

Stated = tuple[float, bool]
"""A probability that was stated, and whether what it was stated of is so."""


@dataclass(frozen=True)
class Bin:
    """Statements of about the same probability."""

    stated: float
    true: float  # share of them that is so
    low: float  # of the 95 % interval (Clopper and Pearson 1934)
    high: float
    count: int


def presences(cases: Iterable[Case]) -> list[Stated]:
    """``present`` of every cause of every answer whose truth is fully known (all tiers but real cameras)."""
    return [
        (sureness(cause), not case.there.isdisjoint((cause["effect"], *cause.get("alike", ()))))
        for case in cases
        if case.tier != "T5"
        for cause in case.answer.get("causes", ())
    ]


def completenesses(cases: Iterable[Case]) -> list[Stated]:
    """``complete`` of every answer that has it, and whether the causes held all that was withheld."""
    found = []
    for case in cases:
        stated = case.answer.get("complete")
        if case.tier not in ("T5", "T6") and isinstance(stated, dict) and not case.failed:
            found.append((float(stated["score"]), case.everything <= set(case.causes)))
    return found


def reliability(stated: Sequence[Stated]) -> list[Bin]:
    """Statements in bins of a tenth; empty bins are left out."""
    if not stated:
        return []
    probability = np.array([each[0] for each in stated])
    true = np.array([each[1] for each in stated], bool)
    place = np.minimum((probability * BINS).astype(int), BINS - 1)
    bins = []
    for i in np.unique(place):
        own = place == i
        hits, count = int(true[own].sum()), int(own.sum())
        bins.append(Bin(float(probability[own].mean()), hits / count, *interval(hits, count), count))
    return bins


def expected_calibration_error(stated: Sequence[Stated]) -> float:
    """Mean distance of bins from the diagonal, by their counts; NaN without statements.

    Source: Naeini, Cooper and Hauskrecht 2015, "Obtaining well calibrated probabilities using Bayesian
    binning".

    >>> round(expected_calibration_error([(0.9, True)] * 9 + [(0.9, False)]), 6)
    0.0
    """
    if not stated:
        return float("nan")
    bins = reliability(stated)
    return sum(each.count * abs(each.true - each.stated) for each in bins) / len(stated)


def coverage(parameters: Sequence[ParameterFound]) -> list[tuple[float, Figure]]:
    """Share of intervals that hold the truth when those of 90 % are scaled to each of `LEVELS`."""
    off = [each.half_widths_off for each in parameters if each.half_widths_off is not None]
    at_90 = stats.norm.ppf(0.95)
    return [
        (level, share("", [each <= stats.norm.ppf((1 + level) / 2) / at_90 for each in off]))
        for level in (LEVELS if off else ())
    ]


def compared(cases: Iterable[Case], *tiers: str) -> list[ParameterFound]:
    return [each for case in cases if case.tier in tiers and not case.failed for each in case.parameters()]


def calibration_figures(
    cases: Sequence[Case], charts: Sequence[Case], natural: Sequence[Case]
) -> list[Figure]:
    named = [c for c in (*charts, *(c for c in cases if c.tier == "T2")) if not c.failed]
    found = {
        "charts": [p for c in charts for p in c.parameters()],
        "natural": [p for c in natural for p in c.parameters()],
        "independent makers": compared(cases, "T4"),
        "nuisances": compared(cases, "T7"),
    }
    everything = compared(cases, "T1", "T4", "T7")
    widths = [p.relative_width for p in everything if p.relative_width is not None]
    said = presences(cases)
    nan = float("nan")
    error = expected_calibration_error(said)
    return [
        share(
            "90 % cause sets hold the truth",
            [set(case.effects) <= set(case.cause_set) for case in named],
            "87 to 93 %",
            lambda value: 0.87 <= value <= 0.93,
        ),
        Figure("Presence stated, expected calibration error", error, nan, nan, len(said)),
        share("Presence stated above 90 % is so", [true for stated, true in said if stated > 0.9]),
        share(
            "90 % parameter intervals hold it",
            [p.holds for p in everything if p.holds is not None],
            "85 to 95 %",
            lambda value: 0.85 <= value <= 0.95,
        ),
        *(
            share(f"90 % parameter intervals, {name}", [p.holds for p in some if p.holds is not None])
            for name, some in found.items()
        ),
        middle("Median half width of parameter intervals, relative", widths),
        _median_error("charts", found["charts"], 0.05),
        _median_error("natural", found["natural"], 0.2),
    ]


def _median_error(name: str, parameters: Sequence[ParameterFound], most: float) -> Figure:
    errors = [each.relative_error for each in parameters]
    return middle(
        f"Median parameter error, {name}", errors, f"<= {most:.0%}".replace("%", " %"), at_most(most)
    )
