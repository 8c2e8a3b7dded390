"""Closed forms: effects that are surely there, and those that surely are not, by arithmetic alone.

A search begins with the first and leaves the others out; see `EffectBase.estimate_from`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from tacos_framework import EffectBase, Estimate, calling, optional, unit_of
from tacos_gap.captures import RealCapture
from tacos_gap.captures.capture import usual_gain_db
from tacos_gap.hypotheses.parameters import HypothesisTerm, initial_guesses_of


@dataclass(frozen=True)
class ClosedForm:
    """Value of a parameter of an effect by arithmetic."""

    effect: str  # name, without ``effect.``
    estimate: Estimate
    neutral: float  # where the parameter does nothing, in its unit
    unit: str

    @property
    def says(self) -> Literal["seen", "excluded", "open"]:
        if self.estimate.is_seen(self.neutral):
            return "seen"
        return "excluded" if self.estimate.is_excluded(self.neutral) else "open"

    def as_data(self) -> dict[str, Any]:
        found = self.estimate
        return {
            "effect": self.effect,
            "parameter": found.parameter,
            "value": float(f"{found.value:.4g}"),
            "standard_error": float(f"{found.standard_error:.2g}"),
            "negligible": found.negligible,
            "unit": self.unit,
            "says": self.says,
        }


def closed_forms(effects: Mapping[str, type[Any]], captures: Sequence[RealCapture]) -> tuple[ClosedForm, ...]:
    """By the captures at the gain that most have: levels in digital numbers are those of one gain."""
    usual_db = usual_gain_db(captures)
    at_one_gain = [capture for capture in captures if capture.context.gain_db == usual_db]
    return tuple(form for name, cls in effects.items() for form in _of(name, cls, at_one_gain))


def _of(name: str, cls: type[Any], captures: Sequence[RealCapture]) -> Iterator[ClosedForm]:
    if not callable(estimate := optional(cls, EffectBase, "estimate_from")):
        return
    with calling(f"effect.{name}", doing="estimate_from"):
        for found in estimate(captures):
            neutral = float(cls.neutral[found.parameter])
            yield ClosedForm(name, found, neutral, unit_of(cls.Config, found.parameter))


def excluded(found: Sequence[ClosedForm]) -> tuple[str, ...]:
    names = dict.fromkeys(form.effect for form in found)
    return tuple(n for n in names if all(f.says == "excluded" for f in found if f.effect == n))


def seen_terms(found: Sequence[ClosedForm], effects: Mapping[str, type[Any]]) -> tuple[HypothesisTerm, ...]:
    """The effects that are surely there, where a search begins with them; parameters not seen are neutral."""
    terms = []
    for name in dict.fromkeys(form.effect for form in found if form.says == "seen"):
        values = {
            form.estimate.parameter: form.estimate.value if form.says == "seen" else form.neutral
            for form in found
            if form.effect == name
        }
        terms += list(initial_guesses_of(name, effects[name], [values]))
    return tuple(terms)
