"""A case after its truth was opened: what was withheld, and what was answered."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from tacos_validation.blind.judgement import RIGHT, SURE, Judgement, KnownTruth, judged, sureness
from tacos_validation.blind.parameters_found import ParameterFound, parameters_found


@dataclass(frozen=True)
class Case:
    name: str
    tier: str
    truth: Mapping[str, Any]
    answer: Mapping[str, Any]  # ``diagnosis.json`` and more; or ``error`` alone
    fresh_gaps: Mapping[str, Any] | None = None  # gaps on captures that were kept back; None where none were

    @property
    def effects(self) -> tuple[str, ...]:
        return tuple(each["effect"] for each in self.truth["withheld"])

    @property
    def everything(self) -> frozenset[str]:
        """Effects that are there: those withheld, and those of a camera that processes its pictures."""
        return frozenset(self.effects) | frozenset(self.truth.get("off", {}).get("pipeline", {}))

    @property
    def units(self) -> float:
        """Severity of the strongest effect as it came out [noise floor]."""
        return max((float(each["units"] or 0) for each in self.truth["withheld"]), default=0.0)

    @property
    def captures(self) -> str:
        return str(self.truth["specification"]["captures"])

    @property
    def nuisance(self) -> str:
        return str(self.truth["specification"]["nuisance"])

    @property
    def failed(self) -> bool:
        return "error" in self.answer

    @property
    def causes(self) -> tuple[str, ...]:
        return tuple(cause["effect"] for cause in self.answer.get("causes", ()))

    @property
    def sureness(self) -> tuple[float, ...]:
        return tuple(sureness(cause) for cause in self.answer.get("causes", ()))

    @property
    def named(self) -> tuple[str, ...]:
        return tuple(name for name, sure in zip(self.causes, self.sureness, strict=True) if sure > SURE)

    @property
    def first(self) -> str:
        """The first cause, or what was said in its place: a verdict, or an error."""
        if self.failed:
            return "error"
        return self.causes[0] if self.causes else str(self.answer["verdict"])

    @property
    def cause_set(self) -> tuple[str, ...]:
        return tuple(self.answer.get("cause_set", ()))

    @property
    def known(self) -> KnownTruth | None:
        """Known truth, where it is less than everything (T5) or more than what was withheld (T7)."""
        return KnownTruth.of(self.truth["known"]) if "known" in self.truth else None

    @property
    def judgement(self) -> Judgement | None:
        return judged(self.known, self.answer) if self.known else None

    @property
    def there(self) -> frozenset[str]:
        known = self.known
        return frozenset(self.effects) | (frozenset({*known.accept, *known.also}) if known else frozenset())

    @property
    def right(self) -> bool:
        if self.failed:
            return False
        if self.judgement:
            return self.judgement.outcome == RIGHT
        if self.tier in ("T0", "speed"):
            return self.answer["verdict"] == "no_gap"
        if self.tier == "T2":
            return set(self.causes) == set(self.effects)
        if self.tier == "T3":
            return self.answer["verdict"] in ("unknown", "partly_explained")
        if self.tier == "T6":
            split = self.truth["specification"]["notes"]["split"]
            return self.first == self.effects[0] if split else len(self.cause_set) > 1
        return self.first in self.effects

    @property
    def confident_and_wrong(self) -> bool:
        if self.judgement:
            return self.judgement.confident_and_wrong
        return bool(self.causes) and not self.right and self.sureness[0] > SURE

    def parameters(self) -> list[ParameterFound]:
        """Parameters of the first cause beside the truth, where that is the one effect withheld."""
        if len(self.effects) != 1 or self.first != self.effects[0]:
            return []
        return parameters_found(self.first, self.truth["withheld"][0]["parameters"], self.answer["causes"][0])

    def as_data(self) -> dict[str, Any]:
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
        return cls(data["case"], data["tier"], data["truth"], data["answer"], data["fresh_gaps"])
