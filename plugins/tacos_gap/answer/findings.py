"""Findings of a diagnosis, and the files they are written as."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from tacos_gap.attribution import Attribution
from tacos_gap.attribution.negative_control import NegativeControl
from tacos_gap.hypotheses.ambiguity import NextCapture
from tacos_gap.hypotheses.closed_forms import ClosedForm
from tacos_gap.hypotheses.kept import as_kept
from tacos_gap.hypotheses.parameters import HypothesisTerm
from tacos_gap.inference.closure import closure
from tacos_gap.inference.location import Place
from tacos_gap.inference.problem import Problem
from tacos_gap.inference.unknown import Unexplained


@dataclass(frozen=True)
class Physical:
    """A parameter as it means the same for every camera: the setting, its value, 90 % interval and unit."""

    name: str
    value: float
    interval: tuple[float, float] | None
    unit: str


@dataclass(frozen=True)
class Parameter:
    """A fitted parameter with its 90 % interval; `interval` is None for one that was chosen, not fitted.

    In pixels and digital numbers it is that of the captured camera; `physical` holds for others too. Where
    the camera sets it anew for each picture, `by_capture` has the value of each, and `value` is their median.
    """

    value: Any
    interval: tuple[float, float] | None
    unit: str
    physical: Physical | None = None
    by_capture: Mapping[str, Parameter] = field(default_factory=dict)


LEAST_PRESENT = 0.5
"""Score from which on an effect is said to be there."""


@dataclass(frozen=True)
class Cause:
    """An effect that the captures support.

    `present` is a score from 0 to 1 that it is there, whatever else is: it goes by the captures that show it.
    Where `alike` names effects that such captures never tell from it, the score is that one of them is there.
    `settings` are those of the captured camera; those of `specimen` among them belong to it alone.
    `closure` is what it closes if it is added alone, `shapley` its fair share of
    what all causes close together; `not_held_out` says why the first is of folds that the selection saw.
    """

    effect: str
    present: float
    parameters: Mapping[str, Parameter]
    closure: float
    closure_interval: tuple[float, float]
    not_held_out: str
    shapley: float
    confused_with: tuple[str, ...]
    evidence: str
    settings: Mapping[str, Any]
    specimen: tuple[str, ...] = ()
    alike: tuple[str, ...] = ()

    @property
    def is_proven(self) -> bool:
        """True if the captures that show it say that it is there, and not only that it would fit."""
        return self.present >= LEAST_PRESENT


@dataclass(frozen=True, eq=False)
class SoFar:
    """Knowledge while a search goes on; `as_data` gives ``so_far.json``.

    `explanation` is the best one by now, empty before there is any.
    """

    closed_forms: Sequence[ClosedForm]
    explanation: Sequence[HypothesisTerm]
    limitations: tuple[str, ...]

    def as_data(self) -> dict[str, Any]:
        """Plain data; `explanation` is where ``--resume`` goes on."""
        return {
            "closed_forms": [form.as_data() for form in self.closed_forms],
            "explanation": as_kept(self.explanation),
            "limitations": list(self.limitations),
        }


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """Findings of a diagnosis; `as_data` gives ``diagnosis.json``.

    `detectable` holds the smallest value of each effect's main parameter that would have shown, `nuisances`
    what each capture's expectation is off by and is no cause. `problem` and `attribution` hold all numbers
    behind it, for the report.
    """

    verdict: str
    gap_before: float
    gap_after: float
    gap_interval: tuple[float, float]
    where: Sequence[Place]
    causes: Sequence[Cause]
    cause_set: tuple[str, ...]
    unknown: Unexplained
    next_capture: NextCapture | None
    below_floor: tuple[str, ...]
    negative_control: NegativeControl | None
    limitations: tuple[str, ...]
    problem: Problem
    attribution: Attribution
    task: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    closure_interval: tuple[float, float] = (0.0, 0.0)
    not_held_out: str = ""
    detectable: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    nuisances: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    closed_forms: Sequence[ClosedForm] = ()

    def as_data(self) -> dict[str, Any]:
        """``diagnosis.json`` as plain data."""
        return {
            "verdict": self.verdict,
            "gap": {
                "before": _round(self.gap_before),
                "after": _round(self.gap_after),
                "floor": 1.0,
                "unit": "floor",
                "ci": [_round(end) for end in self.gap_interval],
                "closure": {
                    "value": _round(self.closure),
                    "ci": [_round(end) for end in self.closure_interval],
                    **_held_out(self.not_held_out),
                },
            },
            "where": [
                {
                    "stage": place.stage,
                    "statistic": place.statistic,
                    "z": _round(place.z),
                    "share": _round(place.share),
                    "at": place.at,
                    "captures": list(place.captures),
                }
                for place in self.where
            ],
            "causes": [_cause_as_data(cause) for cause in self.causes],
            "cause_set": list(self.cause_set),
            "complete": {
                "score": _round(1 - self.unknown.score),
                "by_stage": {name: _round(1 - p) for name, p in self.unknown.by_stage.items()},
                "by_capture": {name: _round(1 - p) for name, p in self.unknown.by_capture.items()},
            },
            "unknown": {"score": self.unknown.score, "where": self.unknown.where},
            "detectable": {effect: dict(limits) for effect, limits in self.detectable.items()},
            "closed_forms": [form.as_data() for form in self.closed_forms],
            "nuisances": {capture: dict(values) for capture, values in self.nuisances.items()},
            "next_capture": self.next_capture
            and {"kind": self.next_capture.kind, "why": self.next_capture.why},
            "below_floor": list(self.below_floor),
            "negative_control": self.negative_control
            and {
                "effects": self.negative_control.effects,
                "among": self.negative_control.among,
                "closure": _round(self.negative_control.closure),
                "ci": [_round(end) for end in self.negative_control.interval],
                "p_value": _round(self.negative_control.p_value),
            },
            "task": {name: dict(values) for name, values in self.task.items()},
            "limitations": list(self.limitations),
        }

    @property
    def closure(self) -> float:
        """Share of the gap that all causes together remove, chosen and fitted on other folds."""
        return closure(self.gap_before, self.gap_after)

    @property
    def effects(self) -> list[dict[str, Any]]:
        return [{"use": f"effect.{cause.effect}", **cause.settings} for cause in self.causes]


def _cause_as_data(cause: Cause) -> dict[str, Any]:
    return {
        "effect": cause.effect,
        "present": _round(cause.present),
        "parameters": {name: _parameter_as_data(parameter) for name, parameter in cause.parameters.items()},
        "closure": {
            "value": _round(cause.closure),
            "ci": [_round(end) for end in cause.closure_interval],
            **_held_out(cause.not_held_out),
        },
        "shapley": _round(cause.shapley),
        "alike": list(cause.alike),
        "confused_with": list(cause.confused_with),
        "evidence": cause.evidence,
    }


def _held_out(why_not: str) -> dict[str, Any]:
    return {"held_out": False, "reason": why_not} if why_not else {"held_out": True}


def _parameter_as_data(parameter: Parameter) -> dict[str, Any]:
    data = _valued(parameter)
    if parameter.physical:
        data["physical"] = {"name": parameter.physical.name, **_valued(parameter.physical)}
    if parameter.by_capture:
        data["by_capture"] = {name: _parameter_as_data(own) for name, own in parameter.by_capture.items()}
    return data


def _valued(parameter: Parameter | Physical) -> dict[str, Any]:
    interval = {"ci": list(parameter.interval)} if parameter.interval else {}
    return {"value": parameter.value, **interval, "unit": parameter.unit}


def _round(value: float) -> float:
    return round(float(value), 3)


def short(value: float) -> float:
    """Five significant digits."""
    return float(f"{value:.5g}")


def as_fine_as(width: float, value: float) -> float:
    """A value to three digits of a width.

    >>> as_fine_as(0.00004812, 1.003212345)
    1.0032123
    """
    if not (math.isfinite(width) and width > 0):
        return short(value)
    return round(float(value), 2 - math.floor(math.log10(width)))
