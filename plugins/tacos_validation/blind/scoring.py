"""Figures of a check, each with its goal."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from tacos_validation.blind.baselines import WAYS
from tacos_validation.blind.calibration import calibration_figures
from tacos_validation.blind.cases import Case
from tacos_validation.blind.figure import Figure, at_least, at_most, middle, share
from tacos_validation.blind.judgement import UNKNOWN

STRONG = 3.6
"""Severity from which a cause must be found: 4, less the tolerance of the amplitude search [noise floor]."""


def figures(cases: Sequence[Case]) -> list[Figure]:
    of: dict[str, list[Case]] = {}
    for case in cases:
        of.setdefault(case.tier, []).append(case)
    first = [case for case in of.get("T1", ()) if case.units >= STRONG]
    charts = [case for case in first if case.captures != "natural"]
    natural = [case for case in first if case.captures == "natural"]
    third = [case for case in of.get("T3", ()) if case.units >= STRONG]
    return [
        share("T0 false alarms", [not c.right for c in of.get("T0", ())], "<= 5 %", at_most(0.05)),
        share("T1 first cause right, charts", [c.right for c in charts], ">= 95 %", at_least(0.95)),
        share("T1 first cause right, natural", [c.right for c in natural], ">= 80 %", at_least(0.8)),
        share("T2 exact set", [c.right for c in of.get("T2", ())], ">= 70 %", at_least(0.7)),
        share(
            "T2 exact set, of presence above 50 %", [set(c.named) == set(c.effects) for c in of.get("T2", ())]
        ),
        share("T3 says that something is unknown", [c.right for c in third], ">= 90 %", at_least(0.9)),
        share("T3 verdict unknown, strictly", [c.answer.get("verdict") == "unknown" for c in third]),
        *_fourth(of.get("T4", ()), charts),
        *_fifth_and_sixth(of.get("T5", ()), of.get("T6", ())),
        *_seventh(of.get("T7", ())),
        share("Crashes and cases past the time limit", [c.failed for c in cases], "none", at_most(0.0)),
        *calibration_figures(cases, charts, natural),
        *_closures(cases),
        *_seconds(of.get("speed", ())),
    ]


def _fourth(cases: Sequence[Case], charts: Sequence[Case]) -> list[Figure]:
    fourth = [case for case in cases if case.units >= STRONG]
    effects = {effect for case in fourth for effect in case.effects}
    alike = [case.right for case in charts if set(case.effects) & effects]
    right = share("T4 first cause right", [case.right for case in fourth])
    loss = float(np.mean(alike)) - right.value if alike and fourth else math.nan
    met = None if math.isnan(loss) else loss <= 0.05
    name = "T4 loss against T1, same effects"
    return [right, Figure(name, loss, math.nan, math.nan, len(fourth), "<= 5 points", met)]


def _fifth_and_sixth(real: Sequence[Case], pairs: Sequence[Case]) -> list[Figure]:
    split = [case for case in pairs if case.truth["specification"]["notes"]["split"]]
    few = [case for case in pairs if not case.truth["specification"]["notes"]["split"]]
    return [
        share("T5 real cases right", [c.right for c in real], ">= 16 of 18", at_least(16 / 18)),
        share("T5 confident and wrong", [c.confident_and_wrong for c in real], "none", at_most(0.0)),
        share("T5 left unknown", [c.judgement is not None and c.judgement.outcome == UNKNOWN for c in real]),
        share("T6 a set, without the splitting capture", [c.right for c in few], "always", at_least(1.0)),
        share("T6 right with the splitting capture", [c.right for c in split]),
    ]


def _seventh(cases: Sequence[Case]) -> list[Figure]:
    """Nuisances; cases whose effect came out weak count for crashes and wrong answers, and for no more."""
    told = [c for c in cases if c.effects and c.units >= STRONG]
    quiet = [c for c in cases if not c.effects]
    return [
        share("T7 first cause right", [first_right(c) for c in told], ">= 90 %", at_least(0.9)),
        share("T7 no answer", [c.failed for c in cases], "none", at_most(0.0)),
        share("T7 confident and wrong", [c.confident_and_wrong for c in cases], "none", at_most(0.0)),
        share("T7 false alarms, nothing withheld", [c.confident_and_wrong for c in quiet]),
        share("T7 right, nothing withheld", [c.right for c in quiet]),
    ]


def first_right(case: Case) -> bool:
    return case.judgement is not None and case.judgement.first_right


def by_nuisance(cases: Sequence[Case]) -> dict[str, tuple[Figure, Figure, list[Case]]]:
    """For each nuisance of T7: first cause right, right with nothing withheld, and its cases."""
    table = {}
    seventh = [case for case in cases if case.tier == "T7"]
    for name in sorted({case.nuisance for case in seventh}):
        own = [case for case in seventh if case.nuisance == name]
        told = [first_right(c) for c in own if c.effects and c.units >= STRONG]
        table[name] = share("", told), share("", [c.right for c in own if not c.effects]), own
    return table


def _closures(cases: Sequence[Case]) -> list[Figure]:
    ratios, differences = [], []
    for case in cases:
        gaps = case.fresh_gaps
        if not gaps or "error" in gaps or not case.causes or gaps["found"] is None:
            continue
        realised = closed(gaps["before"], gaps["found"])
        predicted = closed(case.answer["gap"]["before"], case.answer["gap"]["after"])
        if gaps["before"] > 1.5:
            differences.append(abs(predicted - realised))
        if gaps["truth"] is not None and (oracle := closed(gaps["before"], gaps["truth"])) > 0.2:
            ratios.append(realised / oracle)
    negative_control = [
        c.answer["negative_control"]["closure"] for c in cases if c.answer.get("negative_control")
    ]
    return [
        middle("Realised over oracle closure, fresh captures", ratios, ">= 0.9", lambda v: v >= 0.9, ""),
        middle("Predicted less realised closure", differences, "within 5 points", lambda v: v <= 0.05),
        middle("Closure of the negative control", negative_control, "<= 5 points", lambda v: v <= 0.05),
    ]


def closed(before: float, after: float) -> float:
    """Share of the squared gap above the noise floor that is gone."""
    return 0.0 if before <= 1 else float(np.clip((before**2 - after**2) / (before**2 - 1), -1, 1))


def _seconds(timed: Sequence[Case]) -> list[Figure]:
    """Cases of 640 x 480, scaled to twelve captures."""
    scaled = [12 / c.answer["captures"] * c.answer["seconds"] for c in timed if "seconds" in c.answer]
    return [middle("Seconds for 12 captures of 640 x 480", scaled, "<= 40 s", at_most(40.0), " s")]


def baselines(cases: Sequence[Case]) -> dict[str, dict[str, Figure]]:
    """For the diagnosis and each simpler way: T0 false alarms, T1 first cause right, T2 exact set."""
    answered = [case for case in cases if case.answer.get("baselines")]
    table = {}
    for way in ("the diagnosis", *WAYS):

        def named(case: Case, way: str = way) -> list[str]:
            return list(case.causes) if way == "the diagnosis" else case.answer["baselines"][way]

        strong = [c for c in answered if c.tier == "T1" and c.units >= STRONG]
        charts = [c for c in strong if c.captures != "natural"]
        natural = [c for c in strong if c.captures == "natural"]
        table[way] = {
            "T0 false alarms": share("", [bool(named(c)) for c in answered if c.tier == "T0"]),
            "T1 charts": share("", [named(c)[:1] == list(c.effects) for c in charts]),
            "T1 natural": share("", [named(c)[:1] == list(c.effects) for c in natural]),
            "T2 exact set": share("", [set(named(c)) == set(c.effects) for c in answered if c.tier == "T2"]),
        }
    return table


def ladder(cases: Sequence[Case]) -> list[tuple[float, Figure]]:
    """T1 with charts: share right at each severity that was asked for."""
    found = []
    charts = [case for case in cases if case.tier == "T1" and case.captures != "natural"]
    asked = {case.truth["specification"]["severity"] for case in charts}
    for severity in sorted(value for value in asked if value is not None):
        right = [case.right for case in charts if case.truth["specification"]["severity"] == severity]
        found.append((severity, share(f"{severity:g}", right)))
    return found
