"""Rank agreement of simulations with reality, with what noise and the choice of scenes leave open."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework import generator
from tacos_gap.tasks import CaptureScores
from tacos_validation.task_validation.agreement import (
    Agreement,
    OverSeeds,
    kendall,
    over_seeds,
    rank_agreement,
)

STACKS = ("real", "sim_before", "sim_after")
DRAWS = 1000
"""Draws of noise and scenes."""


@dataclass(frozen=True, eq=False)
class CameraScores:
    """A score of every camera on the same scenes."""

    score: str
    cameras: tuple[str, ...]
    scenes: tuple[str, ...]  # where cameras share no capture, each has one of its own, the mean over all
    means: Mapping[str, NDArray[np.float64]]  # for each stack (cameras, scenes)
    errors: Mapping[str, NDArray[np.float64]]  # standard errors of these over the noise
    lower_is_better: bool = False

    def drawn(self, stack: str, seed: int, *, again: bool = False) -> NDArray[np.float64]:
        """(draws, cameras) what the score might have been with other noise on other scenes like these.

        All stacks draw the same scenes, and every one its own noise; `again` draws other noise of the same.
        """
        count = len(self.scenes)
        scenes = generator(seed, "scenes").integers(count, size=(DRAWS, count))
        rng = generator(seed, "noise", stack, "again" if again else "first")
        noise = rng.normal(size=(DRAWS, len(self.cameras), count))
        value = self.means[stack][None] + self.errors[stack][None] * noise
        return np.take_along_axis(value, scenes[:, None, :], axis=2).mean(axis=2)

    def order(self, stack: str) -> list[str]:
        sign = 1.0 if self.lower_is_better else -1.0
        ranked = np.argsort(sign * self.means[stack].mean(axis=1), kind="stable")
        return [self.cameras[i] for i in ranked]


@dataclass(frozen=True)
class RankFinding:
    """Rank agreement of a simulation with reality."""

    tau: float  # Kendall's rank correlation (tau-b) of the scores as they were measured, in -1..1
    agreement: Agreement
    """Over draws of noise and scenes: mean of tau, the interval that holds 95 % of them, and the share of
    draws in which both put all cameras in one order."""

    def as_data(self) -> dict[str, Any]:
        over = self.agreement.tau
        return {"tau": self.tau, "ci": [over.low, over.high], "same_order": self.agreement.same}


def camera_scores(
    score: str, scored: Mapping[str, Sequence[CaptureScores]], *, lower_is_better: bool = False
) -> CameraScores | None:
    """A score of every camera on the scenes all of them have it for; None where a camera never has it."""
    having = {
        camera: {c.capture: c for c in captures if all(len(c.values(stack, score)) for stack in STACKS)}
        for camera, captures in scored.items()
    }
    if not all(having.values()):
        return None
    shared = [name for name in next(iter(having.values())) if all(name in each for each in having.values())]
    means = {stack: np.zeros((len(having), max(len(shared), 1))) for stack in STACKS}
    errors = {stack: np.zeros_like(means[stack]) for stack in STACKS}
    for row, captures in enumerate(having.values()):
        columns = [[captures[name]] for name in shared] or [list(captures.values())]
        for column, group in enumerate(columns):
            for stack in STACKS:
                means[stack][row, column] = np.mean([c.values(stack, score).mean() for c in group])
                errors[stack][row, column] = _standard_error(group, stack, score)
    return CameraScores(
        score, tuple(having), tuple(shared) or ("all of its own",), means, errors, lower_is_better
    )


def _standard_error(captures: Sequence[CaptureScores], stack: str, score: str) -> float:
    """Of the mean over captures; real frames taken once are taken to spread as the simulated ones do."""
    variances = []
    for each in captures:
        values = each.values(stack, score)
        spreading = values if len(values) > 1 else each.values("sim_after", score)
        variance = float(spreading.var(ddof=1)) if len(spreading) > 1 else 0.0
        variances.append(variance / len(values))
    return float(np.sqrt(np.sum(variances))) / len(captures)


def agreement_with_reality(scores: CameraScores, stack: str, seed: int) -> RankFinding:
    """Rank agreement of a simulation, or of reality under other noise (``real``), with reality."""
    reality = scores.drawn("real", seed)
    other = scores.drawn(stack, seed, again=True)
    return RankFinding(
        float(kendall(*(scores.means[name].mean(axis=1)[None] for name in ("real", stack)))[0]),
        rank_agreement(reality, other),
    )


def level(scores: CameraScores, stack: str, camera: int, seed: int) -> OverSeeds:
    """A camera's score with the interval that holds 95 % of its draws."""
    return over_seeds(scores.drawn(stack, seed)[:, camera])


def as_data(found: OverSeeds) -> dict[str, float]:
    return asdict(found)
