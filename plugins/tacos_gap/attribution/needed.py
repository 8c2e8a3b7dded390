"""Necessity of effects: some are plainly needed, others are not once all is fitted to its end."""

from __future__ import annotations

import numpy as np

from tacos_framework import generator
from tacos_gap.hypotheses.parameters import HypothesisTerm, neutral_value
from tacos_gap.inference.closure import closure, closures_of
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


def hardly_needed(problem: Problem, best: Fitted) -> list[str]:
    """Effects that close nothing of what is held out, or might as well not be there; the least comes first.

    Selection counts log scores, in which a statistic that hardly varies outweighs many that got worse. An
    effect that another one mostly undoes is among them: see `opens_again`.
    """
    if not best.hypothesis:
        return []
    closed = closures_of(problem, best, generator(0, "least needed"), draws=1).fair
    reach = half_widths(problem, best)
    ends = np.cumsum([len(term.free) for term in best.hypothesis])
    found = {}
    for term, end in zip(best.hypothesis, ends, strict=True):
        closes = closed[term.name].value
        if closes <= 0 or (closes < SMALL and _may_be_neutral(term, reach[end - len(term.free) : end])):
            found[term.name] = closes
    return sorted(found, key=lambda name: found[name])


def opens_again(problem: Problem, best: Fitted, fewer: Fitted) -> bool:
    """True if the gap opens without an effect, although all others were fitted anew.

    Of a pedestal that is too high, under a curve that darkens all but black, each by itself may make the gap
    wider, and both together close it.
    """
    before, after, left = (problem.gap(z) for z in (problem.null, best.held_out, fewer.held_out))
    return closure(before, after) - closure(before, left) >= SMALL


def _may_be_neutral(term: HypothesisTerm, reach: np.ndarray) -> bool:
    """True if the interval of each free parameter holds the value that switches the effect off."""
    neutral = [neutral_value(term.cls, name) for name in term.free]
    return bool(term.free) and all(
        at is not None and abs(term.values[name] - at) <= half
        for name, at, half in zip(term.free, neutral, reach, strict=True)
    )
