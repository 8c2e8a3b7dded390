"""The free parameters of a hypothesis, and how the residuals move with them."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from tacos_gap.hypotheses.parameters import HypothesisTerm, series_of
from tacos_gap.inference.problem import Hypothesis, Problem, robust

STEP = 0.25
"""Finite differences take this share of the step that matters of a parameter."""

STRAIGHT = 3.0
"""Root mean square change of residuals up to which they are nearly straight [noise floor]."""

SHORTEST = 1e-3

Column = tuple[str, str, float]
"""Which derivative: of an effect, by a free parameter, per step."""


def theta_of(hypothesis: Hypothesis) -> NDArray[np.float64]:
    return np.concatenate([term.theta for term in hypothesis]) if hypothesis else np.zeros(0)


def free_names(hypothesis: Hypothesis) -> list[str]:
    return [name for term in hypothesis for name in term.free]


def with_theta(hypothesis: Hypothesis, theta: NDArray[np.float64]) -> Hypothesis:
    changed: list[HypothesisTerm] = []
    start = 0
    for term in hypothesis:
        stop = start + len(term.free)
        changed.append(term.with_free(theta[start:stop].tolist()))
        start = stop
    return tuple(changed)


def columns_of(hypothesis: Hypothesis) -> list[Column]:
    return [(term.name, name, step) for term in hypothesis for name, step in term.free.items()]


def jacobian_of(
    problem: Problem,
    hypothesis: Hypothesis,
    z: NDArray[np.float64],
    known: Mapping[Column, NDArray[np.float64]] | None = None,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(K, P) change of the robust residuals per step of each free parameter, and (P,) those steps.

    Columns that are `known` are taken as they are.
    """
    theta = theta_of(hypothesis)
    steps = np.array([step for term in hypothesis for step in term.free.values()])
    steep = {(term.name, name) for term in hypothesis for name in term.free if series_of(term.cls, name)}
    columns = []
    for k, column in enumerate(columns_of(hypothesis)):
        if known and column in known:
            columns.append(known[column])
            continue

        def changed_by(share: float, k: int = k) -> NDArray[np.float64] | None:
            nearby = theta.copy()
            nearby[k] += share * steps[k]
            return problem.residual(with_theta(hypothesis, nearby))

        columns.append(_derivative(changed_by, z, is_steep=column[:2] in steep))
    return (np.stack(columns, axis=1) if columns else np.zeros((len(z), 0))), steps


def _derivative(
    changed_by: Callable[[float], NDArray[np.float64] | None], z: NDArray[np.float64], is_steep: bool
) -> NDArray[np.float64]:
    """(K,) change of the robust residuals per step, by one at `STEP` of it to either side; 0 where refused.

    High powers move the rim of an image by many pixels in a step: those are taken over shorter ones.
    """
    for share in (STEP, -STEP):
        if (changed := changed_by(share)) is None:
            continue
        while is_steep and (far := float(np.sqrt(np.mean((changed - z) ** 2)))) > STRAIGHT:
            share *= max(0.5 * STRAIGHT / far, SHORTEST)
            if (changed := changed_by(share)) is None or abs(share) < SHORTEST:
                break
        if changed is not None:
            return np.asarray((robust(changed) - robust(z)) / share)
    return np.zeros_like(z)


def jacobian_at(problem: Problem, hypothesis: Hypothesis) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """`jacobian_of` where a hypothesis stands, by the same simulations as its neighbours."""
    return jacobian_of(problem, hypothesis, residual_of(problem, hypothesis))


def residual_of(problem: Problem, hypothesis: Hypothesis) -> NDArray[np.float64]:
    z = problem.residual(hypothesis)
    assert z is not None
    return z
