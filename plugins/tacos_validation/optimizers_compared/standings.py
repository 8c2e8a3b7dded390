"""From runs to regret at checkpoints, images to the target, and ratios of them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Quartiles:
    """The median and the quartiles of a figure over runs; infinite where it was not reached."""

    low: float
    median: float
    high: float


def quartiles(values: Sequence[float]) -> Quartiles:
    """Quartiles over runs, between two order statistics by weight.

    Infinite values (never reached) count as larger than all others; between a finite one and an infinite one
    lies an infinite one.

    >>> quartiles([40, 80, 80, 160, float("inf")])
    Quartiles(low=80.0, median=80.0, high=160.0)
    """
    ordered = sorted(map(float, values))

    def at(share: float) -> float:
        place = share * (len(ordered) - 1)
        below, weight = math.floor(place), place % 1
        if weight == 0:
            return ordered[below]
        low, high = ordered[below], ordered[below + 1]
        return high if math.isinf(high) else low + weight * (high - low)

    return Quartiles(at(0.25), at(0.5), at(0.75))


@dataclass(frozen=True)
class JudgedRun:
    """A run as the held-out scenes judge it."""

    optimizer: str
    seed: int
    images: Mapping[int, int]  # images it had rendered when it recommended what stands at each checkpoint
    fitness: Mapping[int, float]
    """At each checkpoint, the fitness on the held-out scenes of what it recommended; minus infinity where it
    recommended nothing, or what cannot be scored there."""

    def images_to(self, target: float) -> float:
        """The first checkpoint at which it is as good as the target; infinite if it never was."""
        return next((float(at) for at, value in self.fitness.items() if value >= target), math.inf)


@dataclass(frozen=True)
class Ratio:
    """Ratio of another optimizer's images to those of this one."""

    value: float | None
    """Median images to the target of the other, over the median of this one; None where this one never
    reaches it."""
    at_least: bool = False
    """True if the other never reached it either, so that its whole budget stands for them."""


@dataclass(frozen=True)
class Standing:
    """Achievement of an optimizer, over its runs."""

    optimizer: str
    runs: int
    regret: Mapping[int, Quartiles]
    """At each checkpoint the distance to the best camera known on the held-out scenes."""
    images: Quartiles  # images to the target
    reached: float  # share of the runs that reached it
    ratios: Mapping[str, Ratio]  # images of other optimizers over its own, by their name
    thought_ms: float  # time in the optimizer itself for each candidate it asked for [ms]


def standings(
    runs: Mapping[str, Sequence[JudgedRun]],
    *,
    target: float,
    best_known: float,
    against: Mapping[str, float],
    budgets: Mapping[str, int],
    thought_ms: Mapping[str, float],
) -> tuple[Standing, ...]:
    """The standing of each optimizer, fewest images to the target first.

    - `target`: fitness on the held-out scenes that is to be reached.
    - `against`: the images that ratios are taken of, by name; infinite where the target was not reached.
    - `budgets`: what stands for them then.
    """
    found = []
    for name, own in runs.items():
        to_target = [run.images_to(target) for run in own]
        images = quartiles(to_target)
        found.append(
            Standing(
                optimizer=name,
                runs=len(own),
                regret={
                    at: quartiles([best_known - run.fitness[at] for run in own]) for at in own[0].fitness
                },
                images=images,
                reached=float(np.mean(np.isfinite(to_target))),
                ratios={
                    other: ratio(theirs, images.median, budgets[other]) for other, theirs in against.items()
                },
                thought_ms=thought_ms[name],
            )
        )
    return tuple(sorted(found, key=_order))


def ratio(theirs: float, own: float, their_budget: int) -> Ratio:
    """Ratio of the images `own` to the images `theirs`.

    >>> ratio(2064, 160, 2064)
    Ratio(value=12.9, at_least=False)
    >>> ratio(float("inf"), 160, 5280)
    Ratio(value=33.0, at_least=True)
    """
    if math.isinf(own):
        return Ratio(None)
    return Ratio(their_budget / own, True) if math.isinf(theirs) else Ratio(theirs / own)


def _order(standing: Standing) -> tuple[float, float]:
    last = max(standing.regret)
    return standing.images.median, standing.regret[last].median
