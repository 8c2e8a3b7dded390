"""Findings of a rank agreement."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from tacos_framework import Evaluation
from tacos_validation.rank_agreement.agreement import Agreement, DecidedPairs, places

SIZES = ("quick", "full")
"""The study as it stands, and at full size."""


@dataclass(frozen=True)
class RankedLight:
    """The orders of both studies in one light."""

    name: str
    agreement: Agreement
    by_score: Mapping[str, float | None]
    """Tau-b of each score that both report for all cameras; None where a study gives all the same."""
    evaluations: Mapping[str, Mapping[str, Evaluation]]
    """For each size what came out for each camera, by name."""
    of_halves: float | None = None
    """Median tau-b of the study at full size with itself, on two halves of the scenes; None where unknown."""
    decided: DecidedPairs | None = None
    """Pairs that the study at full size tells apart; None where it has one scene."""

    @property
    def ranked(self) -> tuple[str, ...]:
        quick, full = (self.evaluations[size] for size in SIZES)
        return tuple(n for n in quick if quick[n].fitness is not None and full[n].fitness is not None)

    def fitness(self, size: str) -> dict[str, float]:
        return {name: float(self.evaluations[size][name].fitness or 0.0) for name in self.ranked}

    def places(self, size: str) -> dict[str, float]:
        return places(self.fitness(size))

    def order(self, size: str) -> list[str]:
        """The ranked cameras, the best first; those with equal places as they stand at full size."""
        own, full = self.places(size), self.places("full")
        return sorted(self.ranked, key=lambda name: (own[name], full[name]))

    @property
    def not_told_apart(self) -> tuple[str, ...]:
        """Cameras to which the small study gives one fitness, though they differ at full size."""
        quick, full = (self.fitness(size) for size in SIZES)
        return tuple(
            name
            for name in self.ranked
            if any(quick[name] == quick[other] and full[name] != full[other] for other in self.ranked)
        )

    def left_out(self) -> list[dict[str, str]]:
        return [
            {"camera": name, "light": self.name, "study": size, "why": evaluation.failed or "no fitness"}
            for size in SIZES
            for name, evaluation in self.evaluations[size].items()
            if evaluation.fitness is None
        ]


@dataclass(frozen=True)
class RankOutcome:
    """Everything the report tells. `scenes`: scenes behind every figure."""

    study: str
    gate: float
    fewest: int
    confidence: float
    scenes: int
    lights: tuple[RankedLight, ...]
    notes: tuple[str, ...]

    @property
    def doubts(self) -> tuple[str, ...]:
        found = []
        for light in self.lights:
            tau = light.agreement.tau
            if len(light.ranked) < self.fewest:
                found.append(
                    f"By {light.name} only {len(light.ranked)} cameras have a place in both orders; "
                    f"the gate asks for {self.fewest}."
                )
            if tau is None:
                found.append(
                    f"By {light.name} there is no order: a study gives all cameras the same fitness."
                )
            elif tau < self.gate:
                found.append(f"By {light.name} tau is {tau:.2f}, below {self.gate:g}.")
            if tau is not None and (equal := light.not_told_apart):
                found.append(
                    f"By {light.name} the study gives the same fitness to cameras that differ at full size: "
                    f"{', '.join(equal)}."
                )
        return tuple(found)

    @property
    def passes(self) -> bool:
        return not self.doubts

    @property
    def shared(self) -> str:
        halves = [
            f"{light.of_halves:.2f} by {light.name}" for light in self.lights if light.of_halves is not None
        ]
        return (
            "Both see the same scenes, so tau says whether being small changes the order, not whether so few "
            "scenes settle it."
        ) + (
            f" With itself, on one half of the scenes and on the other, the study at full size has a tau of "
            f"{' and '.join(halves)} (median)."
            if halves
            else ""
        )

    @property
    def of_decided_pairs(self) -> str:
        """What becomes of pairs that the study at full size tells apart; empty where that is unknown."""
        return " ".join(
            f"By {light.name} the study at full size tells {light.decided.pairs} of "
            f"{math.comb(len(light.ranked), 2)} pairs of cameras apart on these scenes, and the small one "
            f"orders {light.decided.alike} of them alike."
            for light in self.lights
            if light.decided is not None
        )

    def as_data(self) -> dict[str, Any]:
        intervals = {light.name: light.agreement.interval for light in self.lights}
        return {
            "study": self.study,
            "tau": {light.name: light.agreement.tau for light in self.lights},
            "tau_interval": {name: list(found) if found else None for name, found in intervals.items()},
            "tau_of_halves": {light.name: light.of_halves for light in self.lights},
            "pairs_decided": {
                light.name: asdict(light.decided) if light.decided else None for light in self.lights
            },
            "tau_by_score": {light.name: dict(light.by_score) for light in self.lights},
            "passes": self.passes,
            "doubts": list(self.doubts),
            "gate": self.gate,
            "scenes": self.scenes,
            "table": [row for light in self.lights for row in _rows(light)],
            "left_out": [row for light in self.lights for row in light.left_out()],
            "cost": self.cost(),
            "rank_notes": [note for note in (self.shared, self.of_decided_pairs, *self.notes) if note],
        }

    def cost(self) -> dict[str, dict[str, float]]:
        """Images and seconds of each size, all cameras and lights together."""
        return {
            size: {
                "images": sum(e.images for light in self.lights for e in light.evaluations[size].values()),
                "seconds": sum(
                    sum(e.seconds.values()) for light in self.lights for e in light.evaluations[size].values()
                ),
            }
            for size in SIZES
        }


def _rows(light: RankedLight) -> list[dict[str, Any]]:
    fitness = {size: light.fitness(size) for size in SIZES}
    ranks = {size: light.places(size) for size in SIZES}
    return [
        {
            "camera": name,
            "light": light.name,
            **{size: fitness[size][name] for size in SIZES},
            **{f"rank_{size}": ranks[size][name] for size in SIZES},
            "scores": {size: dict(light.evaluations[size][name].scores) for size in SIZES},
        }
        for name in light.order("full")
    ]
