"""Parameters of a hypothesis: a damped quasi-Newton search on the residuals, and what they are worth.

A simulation of all captures is what costs, so the Jacobian is taken once and then kept up with what the steps
themselves show (Broyden 1965).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_gap.parameters import HypothesisTerm
from tacos_gap.problem import ROBUST_SCALE, Hypothesis, Problem, robust, robust_derivative

ITERATIONS = 5
STEP = 0.25
"""Finite differences take this share of the step that matters of a parameter."""

CONVERGED = 0.005
"""Relative gain below which the search stops."""


@dataclass(frozen=True, eq=False)
class Fitted:
    """A hypothesis with fitted parameters.

    Parameters
    ----------
    hypothesis
        The effects, with the best parameters.
    z
        (K,) residuals left [noise floor].
    jacobian
        (K, P) change of the robust residuals per step of each free parameter.
    steps
        (P,) those steps, in the parameters' units.
    score
        Log score on held-out conditions [nat]; higher is better.
    held_out
        (K,) residuals where each half is predicted with parameters fitted on the other [noise floor].
    """

    hypothesis: Hypothesis
    z: NDArray[np.float64]
    jacobian: NDArray[np.float64]
    steps: NDArray[np.float64]
    score: float
    held_out: NDArray[np.float64]

    @property
    def names(self) -> tuple[str, ...]:
        """The effects, in order."""
        return tuple(term.name for term in self.hypothesis)


def fit(problem: Problem, hypothesis: Hypothesis, iterations: int = ITERATIONS) -> Fitted | None:
    """Fit all free parameters of a hypothesis together.

    Returns
    -------
    None where its start is refused.
    """
    z = problem.residual(hypothesis)
    if z is None:
        return None
    jacobian, steps = jacobian_of(problem, hypothesis, z)
    damping = 1e-2
    for _ in range(iterations):
        if not len(steps):
            break
        moved = _improved(problem, hypothesis, z, jacobian, steps, damping)
        if moved is None:
            break
        better, better_z, damping = moved
        gain = 1 - _cost(better_z) / max(_cost(z), 1e-9)
        step = (theta_of(better) - theta_of(hypothesis)) / steps
        if (length := float(np.linalg.norm(step))) >= STEP:  # what a shorter one shows is rounding of codes
            missed = robust(better_z) - robust(z) - jacobian @ step
            jacobian = jacobian + np.outer(missed, step) / length**2
        hypothesis, z = better, better_z
        if gain < CONVERGED:
            break
    return _fitted(problem, hypothesis, z, jacobian, steps)


def finished(problem: Problem, fitted: Fitted) -> Fitted:
    """A fit led to its end: steps with the Jacobian taken anew, until they gain next to nothing."""
    hypothesis, z = fitted.hypothesis, fitted.z
    jacobian, steps = jacobian_of(problem, hypothesis, z)
    for _ in range(ITERATIONS if len(steps) else 0):
        moved = _improved(problem, hypothesis, z, jacobian, steps, damping=1e-4)
        if moved is None:
            break
        gain = 1 - _cost(moved[1]) / max(_cost(z), 1e-9)
        hypothesis, z, _ = moved
        jacobian, _ = jacobian_of(problem, hypothesis, z)
        if gain < CONVERGED:
            break
    return _fitted(problem, hypothesis, z, jacobian, steps)


def rescored(problem: Problem, fitted: Fitted, before: NDArray[np.float64]) -> Fitted:
    """A fit in the units of a reweighted problem, to first order; `before` is the scale it was made with."""
    factor = before / problem.scale
    z = fitted.z * factor
    jacobian = fitted.jacobian * (factor * robust_derivative(z) / robust_derivative(fitted.z))[:, None]
    return _fitted(problem, fitted.hypothesis, z, jacobian, fitted.steps)


def _fitted(
    problem: Problem,
    hypothesis: Hypothesis,
    z: NDArray[np.float64],
    jacobian: NDArray[np.float64],
    steps: NDArray[np.float64],
) -> Fitted:
    held_out = _held_out(problem, hypothesis, z, jacobian, steps)
    score = -0.5 * problem.weight * float(np.sum(robust(held_out) ** 2))
    return Fitted(hypothesis, z, jacobian, steps, score, held_out)


def _cost(z: NDArray[np.float64]) -> float:
    return float(np.sum(robust(z) ** 2))


def theta_of(hypothesis: Hypothesis) -> NDArray[np.float64]:
    """All free parameters, effect by effect."""
    return np.concatenate([term.theta for term in hypothesis]) if hypothesis else np.zeros(0)


def with_theta(hypothesis: Hypothesis, theta: NDArray[np.float64]) -> Hypothesis:
    """The hypothesis with other values of its free parameters."""
    changed: list[HypothesisTerm] = []
    start = 0
    for term in hypothesis:
        stop = start + len(term.free)
        changed.append(term.with_free(theta[start:stop].tolist()))
        start = stop
    return tuple(changed)


def jacobian_of(
    problem: Problem, hypothesis: Hypothesis, z: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(K, P) change of the robust residuals per step of each free parameter, and (P,) those steps."""
    theta = theta_of(hypothesis)
    steps = np.array([step for term in hypothesis for step in term.free.values()])
    columns = []
    for k, step in enumerate(steps):
        for side in (1, -1):
            nearby = theta.copy()
            nearby[k] += side * STEP * step
            changed = problem.residual(with_theta(hypothesis, nearby))
            if changed is not None:
                columns.append((robust(changed) - robust(z)) / (side * STEP))
                break
        else:
            columns.append(np.zeros_like(z))
    return (np.stack(columns, axis=1) if columns else np.zeros((len(z), 0))), steps


def _improved(
    problem: Problem,
    hypothesis: Hypothesis,
    z: NDArray[np.float64],
    jacobian: NDArray[np.float64],
    steps: NDArray[np.float64],
    damping: float,
) -> tuple[Hypothesis, NDArray[np.float64], float] | None:
    """A better point, trying ever shorter steps; None when there is none."""
    theta = theta_of(hypothesis)
    normal = jacobian.T @ jacobian
    gradient = jacobian.T @ robust(z)
    for _ in range(4):
        scaled = normal + damping * (np.diag(np.diag(normal)) + 1e-9 * np.eye(len(normal)))
        move = -np.linalg.lstsq(scaled, gradient, rcond=None)[0]
        move *= min(1.0, 4.0 / max(float(np.abs(move).max()), 1e-9))  # at most four steps that matter
        candidate = with_theta(hypothesis, theta + move * steps)
        changed = problem.residual(candidate)
        if changed is not None and _cost(changed) < _cost(z):
            return candidate, changed, damping / 3
        damping = max(damping * 10, 0.1)
    return None


def _held_out(
    problem: Problem,
    hypothesis: Hypothesis,
    z: NDArray[np.float64],
    jacobian: NDArray[np.float64],
    steps: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Residuals of each fold with the parameters the other fold alone would have chosen, to first order."""
    if not jacobian.shape[1]:
        return z
    straight = robust(z)
    predicted = straight.copy()
    for held in (problem.fold, ~problem.fold):
        own = jacobian[~held]
        normal = own.T @ own
        ridge = 1e-6 * max(float(np.trace(normal)) / len(normal), 1e-12)
        move = -np.linalg.solve(normal + (ridge + 1.0) * np.eye(len(normal)), own.T @ straight[~held])
        move = _within_bounds(hypothesis, np.clip(move, -2, 2), steps)
        predicted[held] = straight[held] + jacobian[held] @ move
    return np.asarray(ROBUST_SCALE * np.sinh(predicted / ROBUST_SCALE))


def _within_bounds(
    hypothesis: Hypothesis, move: NDArray[np.float64], steps: NDArray[np.float64]
) -> NDArray[np.float64]:
    """As much of a move as the effects allow: no camera is predicted that none of them could be."""
    theta = theta_of(hypothesis)
    for share in (1.0, 0.5, 0.25, 0.125):
        if all(term.placed() is not None for term in with_theta(hypothesis, theta + share * move * steps)):
            return share * move
    return np.zeros_like(move)
