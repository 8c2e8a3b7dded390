"""From runs to curves, intervals and a table."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_validation.optimizers_compared.contest import Moment, Run

CONFIDENCE = 0.95


@dataclass(frozen=True)
class Middle:
    """A median and its interval; infinite where it was not reached."""

    median: float
    low: float
    high: float


def middle(values: Sequence[float]) -> Middle:
    """Median with a distribution-free interval: the order statistics that hold it with `CONFIDENCE`.

    Five values or fewer cannot give that confidence; the interval is then their whole range. Infinite values
    (never reached) count as larger than all others.
    """
    from scipy.stats import binom

    ordered = sorted(values)
    count = len(ordered)
    places = range(1, count // 2 + 1)
    place = max((k for k in places if 1 - 2 * binom.cdf(k - 1, count, 0.5) >= CONFIDENCE), default=1)
    lower, upper = ordered[(count - 1) // 2], ordered[count // 2]
    median = upper if math.isinf(upper) else (lower + upper) / 2
    return Middle(median, ordered[place - 1], ordered[count - place])


@dataclass(frozen=True, eq=False)
class RegretCurve:
    """Median regret of an optimizer over its runs, with the interval of `middle`.

    Parameters
    ----------
    at
        (points,) images or seconds.
    median, low, high
        (points,) regret.
    """

    at: NDArray[np.float64]
    median: NDArray[np.float64]
    low: NDArray[np.float64]
    high: NDArray[np.float64]


def curve(
    runs: Sequence[Run],
    at: NDArray[np.float64],
    cost: Callable[[Moment], float],
    *,
    best_known: float,
    worst_known: float,
) -> RegretCurve:
    """Regret of the runs once they had spent so much.

    Before its first scored candidate a run stands at the worst fitness known.
    """
    regret = np.array(
        [[best_known - best_after(run, spent, cost, worst_known) for spent in at] for run in runs]
    )
    middles = [middle(column) for column in regret.T.tolist()]
    return RegretCurve(
        at, *(np.array([getattr(m, name) for m in middles]) for name in ("median", "low", "high"))
    )


def best_after(run: Run, spent: float, cost: Callable[[Moment], float], otherwise: float) -> float:
    """Best fitness once no more than `spent` had been spent."""
    within = [moment.best for moment in run.moments if cost(moment) <= spent]
    return within[-1] if within else otherwise


def reached(run: Run, target: float, cost: Callable[[Moment], float]) -> float:
    """What had been spent when the run first was as good as `target`; infinite if it never was."""
    return next((cost(moment) for moment in run.moments if moment.best >= target), math.inf)


@dataclass(frozen=True)
class Standing:
    """What an optimizer achieved under a scheme, over its runs.

    Parameters
    ----------
    final
        Best fitness after the budget.
    regret
        Distance of that from the best fitness any run found.
    images, seconds
        Spent until the target was reached.
    success
        Share of the runs that reached it.
    success_early
        Share of the runs that reached it with a tenth of the reference's images.
    unseen
        Mean fitness of the winners on test scenes; NaN where there are none.
    thought_ms
        Time in the optimizer itself for each candidate asked [ms].
    """

    optimizer: str
    scheme: str
    runs: int
    final: Middle
    regret: Middle
    images: Middle
    seconds: Middle
    success: float
    success_early: float
    unseen: float | None
    thought_ms: float


def standing(
    runs: Sequence[Run],
    *,
    target: float,
    early_images: float,
    best_known: float,
    worst_known: float,
    unseen: Sequence[float],
) -> Standing:
    """The standing of the runs of one optimizer under one scheme."""
    finals = [run.moments[-1].best if run.moments else worst_known for run in runs]
    images = [reached(run, target, lambda moment: moment.images) for run in runs]
    asked = sum(run.moments[-1].asked for run in runs if run.moments)
    return Standing(
        optimizer=runs[0].optimizer_name,
        scheme=runs[0].scheme,
        runs=len(runs),
        final=middle(finals),
        regret=middle([best_known - final for final in finals]),
        images=middle(images),
        seconds=middle([reached(run, target, lambda moment: moment.seconds) for run in runs]),
        success=float(np.mean(np.isfinite(images))),
        success_early=float(np.mean(np.array(images) <= early_images)),
        unseen=float(np.mean(unseen)) if unseen else None,
        thought_ms=1e3 * sum(run.thought_seconds for run in runs) / max(asked, 1),
    )
