"""Cameras ranked on scenes that none was chosen by, with what is not known of their order."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Evaluation, Fitness, generator
from tacos_framework.study import PairedInterval, confidence_interval, contributions

DRAWS = 2000
"""Resamples of the scenes; a probability of 10 % is then good to 1 %."""


@dataclass(frozen=True)
class RankedCameras:
    """Cameras in one simulation."""

    evaluations: Mapping[str, Evaluation]
    intervals: Mapping[str, tuple[float, float] | None] = field(default_factory=dict)
    """Interval of each fitness over scenes; None where there are too few."""
    chance_best: Mapping[str, float] = field(default_factory=dict)
    """Share of the resampled sets of scenes on which a camera is the best."""
    comparisons: Mapping[str, PairedInterval] = field(default_factory=dict)
    """The reference less each other camera, as the sequential test left it."""
    reference: str = ""  # the camera that the others are compared with

    @property
    def order(self) -> list[str]:
        """Names, the best first; what failed last."""
        return sorted(self.evaluations, key=lambda name: -fitness_of(self.evaluations[name]))

    @property
    def episodes(self) -> int:
        return min((len(e.blocks) for e in self.evaluations.values() if e.fitness is not None), default=0)


def fitness_of(evaluation: Evaluation) -> float:
    """The fitness; minus infinity for what failed."""
    return float("-inf") if evaluation.fitness is None else evaluation.fitness


def ranked(
    evaluations: Mapping[str, Evaluation],
    fitness: Fitness,
    *,
    error: float,
    seed: int,
    comparisons: Mapping[str, PairedInterval] | None = None,
    reference: str = "",
) -> RankedCameras:
    """Rank cameras that saw the same scenes.

    - `evaluations`: of each camera, block for block on the same scenes.
    - `error`: share of studies in which an interval may miss the truth.
    - `comparisons`, `reference`: as in `RankedCameras`.
    """
    scored = {name: each for name, each in evaluations.items() if each.fitness is not None}
    values = {name: contributions(each.blocks, fitness) for name, each in scored.items()}
    known = {name: v for name, v in values.items() if v is not None}
    intervals = {
        name: confidence_interval(known[name], error) if name in known else None for name in evaluations
    }
    chances = chance_best(known, seed) if known and len(known) == len(values) else {}
    return RankedCameras(evaluations, intervals, chances, comparisons or {}, reference)


def chance_best(values: Mapping[str, NDArray[np.float64]], seed: int) -> dict[str, float]:
    """Share of draws of scenes on which each camera is the best, all cameras on the same ones.

    - `values`: (n,) what each scene tells about a camera's fitness, by name.

    >>> chance_best({"a": np.array([1.0, 2.0]), "b": np.array([0.0, 1.0])}, seed=1)
    {'a': 1.0, 'b': 0.0}
    """
    table = np.stack(list(values.values()))
    drawn = generator(seed, "chance best").integers(table.shape[1], size=(DRAWS, table.shape[1]))
    best = np.argmax(table[:, drawn].mean(axis=-1), axis=0)
    shares = np.bincount(best, minlength=len(table)) / DRAWS
    return dict(zip(values, shares.tolist(), strict=True))
