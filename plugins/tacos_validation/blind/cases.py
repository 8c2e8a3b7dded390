"""A case after its truth was opened: what was withheld, and what was answered."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

NEUTRAL = {"scale": 1.0, "gamma": 1.0, "level_dn": 255.0, "step_dn": 1.0, "quality": 100.0}
"""Neutral values that are not 0; of white balance `red` and `blue` are neutral at 1 too."""

NOT_COMPARED = frozenset(
    {"angle_deg", "period_rows", "radius_px of sharpening", "step_dn", "quality", "hot_share"}
)
"""Parameters without an amplitude, or chosen rather than fitted."""

SUMMED = {
    "vignetting": ("k1", "k2", "k3"),
    "lens-shading-correction": ("k1", "k2"),
    "nonlinearity": ("a2", "a3"),
}
"""Coefficients of a polynomial stand for one another; what they come to at 1 is compared."""

OWN_SCALE = frozenset({"denoise"})
"""Effects whose parameter means something else for the generator than for the catalogue."""


@dataclass(frozen=True)
class Case:
    """One case.

    Parameters
    ----------
    name
        Its random name.
    tier
        ``T0`` to ``T6``.
    truth
        What was withheld, as committed to.
    answer
        ``diagnosis.json`` and more; or ``error`` alone.
    fresh_gaps
        Gaps on captures that were kept back; None where none were.
    """

    name: str
    tier: str
    truth: Mapping[str, Any]
    answer: Mapping[str, Any]
    fresh_gaps: Mapping[str, Any] | None = None

    @property
    def effects(self) -> tuple[str, ...]:
        """What was withheld."""
        return tuple(each["effect"] for each in self.truth["withheld"])

    @property
    def units(self) -> float:
        """Severity of the strongest effect as it came out [noise floor]."""
        return max((float(each["units"] or 0) for each in self.truth["withheld"]), default=0.0)

    @property
    def captures(self) -> str:
        """Name of its set of captures."""
        return str(self.truth["specification"]["captures"])

    @property
    def failed(self) -> bool:
        """Whether there was no answer at all."""
        return "error" in self.answer

    @property
    def causes(self) -> tuple[str, ...]:
        """What was named, best first."""
        return tuple(cause["effect"] for cause in self.answer.get("causes", ()))

    @property
    def first(self) -> str:
        """The first cause, or what was said in its place: a verdict, or an error."""
        if self.failed:
            return "error"
        return self.causes[0] if self.causes else str(self.answer["verdict"])

    @property
    def cause_set(self) -> tuple[str, ...]:
        """Effects among which the answer says the truth is."""
        return tuple(self.answer.get("cause_set", ()))

    @property
    def right(self) -> bool:
        """Whether the answer is right, as its tier counts it."""
        if self.failed:
            return False
        if self.tier in ("T0", "speed"):
            return self.answer["verdict"] == "no_gap"
        if self.tier == "T2":
            return set(self.causes) == set(self.effects)
        if self.tier == "T3":
            return self.answer["verdict"] in ("unknown", "partly_explained")
        if self.tier == "T5":
            return real_right(self.truth["expects"], self)
        if self.tier == "T6":
            split = self.truth["specification"]["notes"]["split"]
            return self.first == self.effects[0] if split else len(self.cause_set) > 1
        return self.first in self.effects

    @property
    def confident_and_wrong(self) -> bool:
        """Whether a first cause was named with a probability above one half, wrongly."""
        causes = self.answer.get("causes", ())
        return bool(causes) and not self.right and causes[0]["probability"] > 0.5

    def parameter_errors(self) -> list[tuple[float, bool | None]]:
        """Relative errors of the first cause's parameters, and whether their intervals hold the truth."""
        if not self.causes or len(self.effects) != 1 or self.first != self.effects[0]:
            return []
        name, true = self.effects[0], self.truth["withheld"][0]["parameters"]
        found = self.answer["causes"][0]["parameters"]
        if name in OWN_SCALE or not true:
            return []
        if name in SUMMED:
            keys = SUMMED[name]
            total = sum(true[k] for k in keys)
            guess = sum(found[k]["value"] for k in keys if k in found)
            return [(abs(guess - total) / max(abs(total), 1e-9), None)]
        errors: list[tuple[float, bool | None]] = []
        for key, value in true.items():
            neutral = 1.0 if name == "white-balance" else NEUTRAL.get(key, 0.0)
            skipped = key in NOT_COMPARED or f"{key} of {name}" in NOT_COMPARED
            if skipped or not isinstance(value, int | float) or key not in found or value == neutral:
                continue
            guess = found[key]["value"]
            if not isinstance(guess, int | float):
                continue
            interval = found[key].get("ci")
            held = None if interval is None else bool(interval[0] <= value <= interval[1])
            errors.append((abs(guess - value) / abs(value - neutral), held))
        return errors

    def as_data(self) -> dict[str, Any]:
        """A line of ``cases.jsonl``."""
        return {
            "case": self.name,
            "tier": self.tier,
            "right": self.right,
            "truth": dict(self.truth),
            "answer": dict(self.answer),
            "fresh_gaps": self.fresh_gaps,
        }

    @classmethod
    def of(cls, data: Mapping[str, Any]) -> Case:
        """From a line of ``cases.jsonl``."""
        return cls(data["case"], data["tier"], data["truth"], data["answer"], data["fresh_gaps"])


def real_right(expects: Mapping[str, Any], case: Case) -> bool:
    """Whether the answer to a real case is what is known of it.

    `expects` holds ``first`` (effects of which one must come first), or ``at_most`` (effects that may be
    named, and no others).
    """
    if "first" in expects:
        return case.first in expects["first"]
    return set(case.causes) <= set(expects["at_most"]) and case.answer["verdict"] != "unknown"
