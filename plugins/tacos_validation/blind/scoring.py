"""Figures of a check, each with its goal."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from tacos_validation.blind.baselines import WAYS
from tacos_validation.blind.cases import Case

STRONG = 3.6
"""Severity from which a cause must be found: 4, less the tolerance of the amplitude search [noise floor]."""


@dataclass(frozen=True)
class Figure:
    """One figure.

    Parameters
    ----------
    name
        What it is.
    value, low, high
        The figure, and its 95 % interval; NaN where there are no cases.
    count
        Cases, or numbers, behind it.
    goal
        The goal, in words; empty where there is none.
    met
        Whether it is met; None without a goal or cases.
    unit
        ``%`` for shares, else what follows the number.
    """

    name: str
    value: float
    low: float
    high: float
    count: int
    goal: str = ""
    met: bool | None = None
    unit: str = "%"

    def as_data(self) -> dict[str, Any]:
        """For ``result.json``; NaN becomes null."""
        return {
            key: None if isinstance(value, float) and math.isnan(value) else value
            for key, value in asdict(self).items()
        }


def interval(hits: int, count: int) -> tuple[float, float]:
    """95 % interval of a share (Clopper and Pearson 1934).

    Examples
    --------
    >>> [round(end, 3) for end in interval(0, 60)]
    [0.0, 0.06]
    """
    from scipy.stats import beta

    if not count:
        return math.nan, math.nan
    low = 0.0 if hits == 0 else float(beta.ppf(0.025, hits, count - hits + 1))
    high = 1.0 if hits == count else float(beta.ppf(0.975, hits + 1, count - hits))
    return low, high


def share(
    name: str, cases: Iterable[bool], goal: str = "", meets: Callable[[float], bool] | None = None
) -> Figure:
    """A share with its interval."""
    hits = list(cases)
    value = sum(hits) / len(hits) if hits else math.nan
    met = meets(value) if meets and hits else None
    return Figure(name, value, *interval(sum(hits), len(hits)), len(hits), goal, met)


def middle(
    name: str,
    values: Iterable[float],
    goal: str = "",
    meets: Callable[[float], bool] | None = None,
    unit: str = "%",
) -> Figure:
    """A median with its 95 % interval by order statistics."""
    ordered = np.sort(np.asarray(list(values), float))
    count = len(ordered)
    if not count:
        return Figure(name, math.nan, math.nan, math.nan, 0, goal, None, unit)
    reach = 0.98 * math.sqrt(count)
    low, high = math.floor(count / 2 - reach), math.ceil(count / 2 + reach)
    value = float(np.median(ordered))
    ends = float(ordered[max(low, 0)]), float(ordered[min(high, count - 1)])
    return Figure(name, value, *ends, count, goal, meets(value) if meets else None, unit)


def figures(cases: Sequence[Case]) -> list[Figure]:
    """The table of goals of the check."""

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
        share("T3 says that something is unknown", [c.right for c in third], ">= 90 %", at_least(0.9)),
        share("T3 verdict unknown, strictly", [c.answer.get("verdict") == "unknown" for c in third]),
        *_fourth(of.get("T4", ()), charts),
        *_fifth_and_sixth(of.get("T5", ()), of.get("T6", ())),
        *_calibration(charts, natural, of.get("T2", ())),
        *_closures(cases),
        *_seconds(of.get("speed", ())),
    ]


def at_least(least: float) -> Callable[[float], bool]:
    """Meets a goal from below."""
    return lambda value: value >= least


def at_most(most: float) -> Callable[[float], bool]:
    """Meets a goal from above."""
    return lambda value: value <= most


def _fourth(fourth: Sequence[Case], charts: Sequence[Case]) -> list[Figure]:
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
        share("T6 a set, without the splitting capture", [c.right for c in few], "always", at_least(1.0)),
        share("T6 right with the splitting capture", [c.right for c in split]),
    ]


def _calibration(charts: Sequence[Case], natural: Sequence[Case], second: Sequence[Case]) -> list[Figure]:
    named = [case for case in (*charts, *second) if not case.failed]
    held = [h for case in charts for _, h in case.parameter_errors() if h is not None]
    errors = {
        name: [error for case in chosen for error, _ in case.parameter_errors()]
        for name, chosen in (("charts", charts), ("natural", natural))
    }
    return [
        share(
            "90 % cause sets hold the truth",
            [set(case.effects) <= set(case.cause_set) for case in named],
            "87 to 93 %",
            lambda value: 0.87 <= value <= 0.93,
        ),
        share("90 % parameter intervals hold it", held, "85 to 95 %", lambda value: 0.85 <= value <= 0.95),
        middle("Median parameter error, charts", errors["charts"], "<= 5 %", at_most(0.05)),
        middle("Median parameter error, natural", errors["natural"], "<= 20 %", at_most(0.2)),
    ]


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
    """Share of the gap above the noise floor that is gone."""
    return 0.0 if before <= 1 else float(np.clip((before - after) / (before - 1), -1, 1))


def _seconds(timed: Sequence[Case]) -> list[Figure]:
    """Cases of 640 x 480, scaled to twelve captures."""
    scaled = [12 / c.answer["captures"] * c.answer["seconds"] for c in timed if "seconds" in c.answer]
    return [middle("Seconds for 12 captures of 640 x 480", scaled, "<= 60 s", at_most(60.0), " s")]


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
