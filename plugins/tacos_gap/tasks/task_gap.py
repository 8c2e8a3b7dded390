"""The gap of a task: its scores in reality and in simulation, with what noise does to them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.special import stdtrit

from tacos_gap.tasks.scoring import CaptureScores, ScoredTasks

STACKS = ("real", "sim_before", "sim_after")
ERROR = 0.1
"""An interval leaves the score out with this probability."""


@dataclass(frozen=True)
class TaskScore:
    """A score in reality, in the simulation as it was, and with the causes."""

    real: float  # mean over the captures that have it, as the next two
    sim_before: float
    sim_after: float
    intervals: dict[str, tuple[float, float]] | None
    """90 % interval of each, as noise spreads it on the scenes that were photographed; None where no frame
    was taken twice."""
    captures: int  # how many captures have it

    def as_data(self) -> dict[str, Any]:
        means = {name: round(getattr(self, name), 4) for name in STACKS}
        if self.intervals is None:
            return {**means, "ci": None, "captures": self.captures}
        ci = {name: [round(end, 4) for end in ends] for name, ends in self.intervals.items()}
        return {**means, "ci": ci, "captures": self.captures}


def task_gap(scored: ScoredTasks) -> dict[str, TaskScore]:
    found = {}
    for name in scored.names:
        having = [c for c in scored.captures if all(len(c.values(stack, name)) for stack in STACKS)]
        if having:
            found[name] = _score(having, name)
    return found


def _score(captures: Sequence[CaptureScores], name: str) -> TaskScore:
    """A mean over captures; its variance is that of the captures' means, as these scenes are given.

    Real frames are seldom taken often enough to tell how they spread. They are taken to spread as those of
    the better simulation do, or as themselves where they spread more.
    """
    means = {stack: float(np.mean([c.values(stack, name).mean() for c in captures])) for stack in STACKS}
    spread = {stack: _within_variance(captures, stack, name) for stack in STACKS}
    if spread["sim_after"] is None or spread["sim_before"] is None:
        return TaskScore(**means, intervals=None, captures=len(captures))
    own = spread["real"]
    if own is None or own[0] < spread["sim_after"][0]:
        spread["real"] = spread["sim_after"]
    intervals = {}
    for stack, found in spread.items():
        assert found is not None
        variance, freedom = found
        repeats = [len(c.values(stack, name)) for c in captures]
        error = math.sqrt(variance * sum(1 / n for n in repeats)) / len(captures)
        reach = float(stdtrit(freedom, 1 - ERROR / 2)) * error
        intervals[stack] = means[stack] - reach, means[stack] + reach
    return TaskScore(**means, intervals=intervals, captures=len(captures))


def _within_variance(captures: Sequence[CaptureScores], stack: str, name: str) -> tuple[float, int] | None:
    """Variance of a score from draw to draw of the noise, pooled over captures, and degrees of freedom."""
    values = [c.values(stack, name) for c in captures]
    freedom = sum(len(v) - 1 for v in values)
    if not freedom:
        return None
    return sum(float(((v - v.mean()) ** 2).sum()) for v in values) / freedom, freedom
