"""Findings of a comparison of optimizers."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from tacos_validation.harness import csv_text
from tacos_validation.optimizers_compared.standings import JudgedRun, Standing


@dataclass(frozen=True, eq=False)
class Comparison:
    """Everything the report tells."""

    problem: str
    target_of: str  # whose quality the target is, in words
    target: float  # the median of that quality on the held-out scenes
    target_images: float  # images those runs had rendered for it, in the median
    best_known: float
    best_camera: Mapping[str, Any]
    held_out: int
    runs: Mapping[str, Sequence[JudgedRun]]
    standings: tuple[Standing, ...]
    rendered: int  # images rendered in all, as runs share a table
    notes: tuple[str, ...]

    def as_data(self) -> dict[str, Any]:
        """For ``result.json``; what was never reached, or never scored, is null."""
        plain: dict[str, Any] = _finite(
            {
                "problem": self.problem,
                "target_of": self.target_of,
                "target": self.target,
                "target_images": self.target_images,
                "best_known": self.best_known,
                "best_camera": dict(self.best_camera),
                "held_out_scenes": self.held_out,
                "standings": [asdict(each) for each in self.standings],
                "rendered": self.rendered,
            }
        )
        return {**plain, "comparison_notes": list(self.notes)}


def curves_csv(comparison: Comparison) -> str:
    rows = []
    for runs in comparison.runs.values():
        for run in runs:
            for at, fitness in run.fitness.items():
                scored = [fitness, comparison.best_known - fitness] if math.isfinite(fitness) else ["", ""]
                rows.append((run.optimizer, run.seed, at, run.images[at], *scored))
    return csv_text(("optimizer", "seed", "checkpoint", "images", "held_out_fitness", "regret"), rows)


def standings_csv(comparison: Comparison) -> str:
    heads = ("regret_low", "regret_median", "regret_high", "images_to_target", "reached")
    rows = []
    for each in comparison.standings:
        for at, regret in each.regret.items():
            figures = [regret.low, regret.median, regret.high, each.images.median, each.reached]
            rows.append((each.optimizer, at, *map(_finite, figures)))
    return csv_text(("optimizer", "checkpoint", *heads), rows)


def _finite(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _finite(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
