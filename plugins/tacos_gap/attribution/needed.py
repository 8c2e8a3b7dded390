"""Necessity of effects: some are plainly needed, others are not once all is fitted to its end."""

from __future__ import annotations

import numpy as np

from tacos_framework import generator
from tacos_gap.hypotheses.parameters import HypothesisTerm, neutral_value
from tacos_gap.inference.closure import closures_of
from tacos_gap.inference.fit import Fitted
from tacos_gap.inference.intervals import half_widths
from tacos_gap.inference.jacobian import columns_of
from tacos_gap.inference.problem import Problem, robust, without
from tacos_gap.inference.pruning import PLAINLY

SMALL = 0.05
"""Share of the gap below which an effect must part from neutral to be named."""


def is_plainly_needed(problem: Problem, fitted: Fitted, name: str, least: float) -> bool:
    """True if all other effects together could not make up for one, as far as first order tells.

    One simulation without it and the Jacobian of the others tell what a fit of these would leave at best.

    `name`: one of its effects. `least`: what an effect must gain to be kept [nat].
    """
    z = problem.residual(without(fitted.hypothesis, name))
    if z is None:
        return True
    others = [k for k, column in enumerate(columns_of(fitted.hypothesis)) if column[0] != name]
    jacobian, straight = fitted.jacobian[:, others], robust(z)
    left = straight - jacobian @ np.linalg.lstsq(jacobian, straight, rcond=1e-6)[0]
    gain = 0.5 * problem.weight * float(np.sum(left**2) - np.sum(robust(fitted.z) ** 2))
    return gain > PLAINLY * least


def least_needed(problem: Problem, best: Fitted) -> str | None:
    """The effect that closes least of what is held out, where it is nothing or might as well not be there.

    Selection counts log scores, in which a statistic that hardly varies outweighs many that got worse. None
    where all effects are needed.
    """
    if not best.hypothesis:
        return None
    closed = closures_of(problem, best, generator(0, "least needed"), draws=1).fair
    reach = half_widths(problem, best)
    ends = np.cumsum([len(term.free) for term in best.hypothesis])
    for term, end in sorted(
        zip(best.hypothesis, ends, strict=True), key=lambda each: closed[each[0].name].value
    ):
        closes = closed[term.name].value
        if closes <= 0 or (closes < SMALL and _may_be_neutral(term, reach[end - len(term.free) : end])):
            return term.name
    return None


def _may_be_neutral(term: HypothesisTerm, reach: np.ndarray) -> bool:
    """True if the interval of each free parameter holds the value that switches the effect off."""
    neutral = [neutral_value(term.cls, name) for name in term.free]
    return bool(term.free) and all(
        at is not None and abs(term.values[name] - at) <= half
        for name, at, half in zip(term.free, neutral, reach, strict=True)
    )
