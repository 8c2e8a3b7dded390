"""Parameters of a hypothesis: a quasi-Newton search in a trust region, and what they are worth.

A simulation of all captures is what costs, so the Jacobian is taken once, as far as no fit nearby knows it,
and then kept up with what the steps themselves show (Broyden 1965); it is taken anew where a step fails with
one that is no longer that of the place.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tacos_gap.hypotheses.by_capture import is_of_one_capture, penalty
from tacos_gap.inference.jacobian import (
    STEP,
    Column,
    columns_of,
    free_names,
    jacobian_at,
    jacobian_of,
    residual_of,
    theta_of,
    with_theta,
)
from tacos_gap.inference.problem import (
    ROBUST_SCALE,
    Hypothesis,
    Problem,
    is_allowed,
    robust,
    robust_derivative,
)

ITERATIONS = 10
REACH = 4.0
"""Steps that matter which the search moves at most at first; each such move that pays doubles it."""

TRIES = 5
"""Ever shorter moves that are tried before a search is given up."""

WORTH_A_STEP = 0.05
"""Gain in log score below which a search has converged [nat]."""

WORTH_A_SKETCH = 0.005
"""Relative gain of the sum of squares below which a first fit stops: most are rivals far from the truth."""

DRAWS = 4
"""Simulations whose mean stands for an explanation once its score is compared."""


@dataclass(frozen=True, eq=False)
class Fitted:
    hypothesis: Hypothesis
    z: NDArray[np.float64]  # (K,) residuals left [noise floor]
    jacobian: NDArray[np.float64]  # (K, P) change of the robust residuals per step of each free parameter
    steps: NDArray[np.float64]  # (P,) those steps, in the parameters' units
    score: float
    """Log score on held-out conditions, less what values of single captures must gain [nat]; higher is
    better."""
    held_out: NDArray[np.float64]
    """(K,) residuals where each half is predicted with parameters fitted on the other [noise floor]."""
    draws: int = 1  # how many simulations `z` is the mean of

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(term.name for term in self.hypothesis)

    @property
    def cost(self) -> float:
        """Sum of the squares of the robust residuals."""
        return _cost(self.z)


def fit(
    problem: Problem, hypothesis: Hypothesis, iterations: int = ITERATIONS, near: Fitted | None = None
) -> Fitted | None:
    """Fit all free parameters of a hypothesis together, well enough to tell whether it is worth finishing.

    - `near`: a fit of most of its effects in the same units: how residuals move with the parameters that both
      have is not simulated again.

    Returns None where its start is refused.
    """
    z = problem.residual(hypothesis)
    if z is None:
        return None
    known = {} if near is None else _columns(near, z)
    state = _State(hypothesis, z, *jacobian_of(problem, hypothesis, z, known), is_exact=not known)
    return _searched(problem, problem, state, iterations, WORTH_A_SKETCH)


def finished(problem: Problem, fitted: Fitted) -> Fitted:
    """A fit led to its end by the mean of several simulations, with the Jacobian of the place it ends at."""
    averaged = problem.averaging(max(DRAWS, problem.draws))
    state = _State(
        fitted.hypothesis, residual_of(averaged, fitted.hypothesis), *jacobian_at(problem, fitted.hypothesis)
    )
    ended = _searched(averaged, problem, state, ITERATIONS, 0.0)
    jacobian, _ = jacobian_at(problem, ended.hypothesis)
    return _fitted(averaged, ended.hypothesis, ended.z, jacobian, ended.steps)


def settled(problem: Problem, fitted: Fitted) -> Fitted:
    """A first fit by the mean of several simulations, from the Jacobian it came to."""
    if fitted.draws >= DRAWS or not fitted.hypothesis:  # that of nothing is the mean of the null replicates
        return fitted
    averaged = problem.averaging(max(DRAWS, problem.draws))
    z = residual_of(averaged, fitted.hypothesis)
    state = _State(fitted.hypothesis, z, fitted.jacobian, fitted.steps, is_exact=False)
    return _searched(averaged, problem, state, 1, WORTH_A_SKETCH)


@dataclass(frozen=True, eq=False)
class _State:
    """State of a search: its place, its reach, and whether its Jacobian is that of the place."""

    hypothesis: Hypothesis
    z: NDArray[np.float64]
    jacobian: NDArray[np.float64]
    steps: NDArray[np.float64]
    damping: float = 1e-2
    reach: float = REACH
    is_exact: bool = True


def _searched(problem: Problem, single: Problem, state: _State, iterations: int, sketch: float) -> Fitted:
    """The search from a state on, until a step is worth next to nothing.

    Jacobians come from the problem of `single` simulations: their differences share their noise.
    """
    for _ in range(iterations if len(state.steps) else 0):
        worth = max(WORTH_A_STEP / (0.5 * problem.weight), sketch * _cost(state.z))
        moved = _improved(problem, state, worth)
        if moved is None:
            if state.is_exact or iterations == 1 or (sketch and _first_promise(state) < worth):
                break
            jacobian, _ = jacobian_at(single, state.hypothesis)
            state = replace(state, jacobian=jacobian, damping=1e-2, reach=REACH, is_exact=True)
            continue
        gain = _cost(state.z) - _cost(moved.z)
        state = moved
        if gain < worth:
            break
    return _fitted(problem, state.hypothesis, state.z, state.jacobian, state.steps)


def rescored(problem: Problem, fitted: Fitted, before: NDArray[np.float64]) -> Fitted:
    """A fit in the units of a reweighted problem, to first order; `before` is the scale it was made with."""
    factor = before / problem.scale
    z = fitted.z * factor
    jacobian = factor[:, None] * jacobian_for(fitted, z)
    return replace(_fitted(problem, fitted.hypothesis, z, jacobian, fitted.steps), draws=fitted.draws)


def _fitted(
    problem: Problem,
    hypothesis: Hypothesis,
    z: NDArray[np.float64],
    jacobian: NDArray[np.float64],
    steps: NDArray[np.float64],
) -> Fitted:
    held_out = _held_out(problem, hypothesis, z, jacobian, steps)
    misfit = float(np.sum(squares_in_own_units(problem, [term.name for term in hypothesis], held_out)))
    score = -0.5 * problem.weight * misfit - penalty(free_names(hypothesis))
    return Fitted(hypothesis, z, jacobian, steps, score, held_out, problem.draws)


def squares_in_own_units(
    problem: Problem, names: Collection[str], z: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(K,) squares of robust residuals in units of an explanation's own noise floor, as log likelihoods are.

    Minus twice those, up to a constant: a wider floor has its price, the logarithm of its square.

    `names`: the effects of the explanation. `z`: (K,) residuals [noise floor of now].
    """
    units = problem.own_units(names)
    return np.asarray(robust(z / units) ** 2 + 2 * np.log(units))


def _cost(z: NDArray[np.float64]) -> float:
    return float(np.sum(robust(z) ** 2))


def _columns(fitted: Fitted, z: NDArray[np.float64]) -> dict[Column, NDArray[np.float64]]:
    return dict(zip(columns_of(fitted.hypothesis), jacobian_for(fitted, z).T, strict=True))


def jacobian_for(fitted: Fitted, z: NDArray[np.float64]) -> NDArray[np.float64]:
    """(K, P) a fit's Jacobian, as it is for robust residuals of (K,) `z`."""
    return np.asarray(fitted.jacobian * (robust_derivative(z) / robust_derivative(fitted.z))[:, None])


def plain_jacobian(fitted: Fitted) -> NDArray[np.float64]:
    """(K, P) change of the residuals themselves per step of each free parameter."""
    return np.asarray(fitted.jacobian / robust_derivative(fitted.z)[:, None])


def _move(state: _State, damping: float, reach: float) -> tuple[NDArray[np.float64], float]:
    """(P,) damped Gauss-Newton step within reach, and how long it would be [steps that matter].

    Parameters that it would lead out of their bounds stay where they are, and the others make up for them.

    Source: Levenberg 1944.
    """
    held = np.zeros(len(state.steps), bool)
    while True:
        jacobian = np.where(held, 0.0, state.jacobian)
        normal = jacobian.T @ jacobian
        damped = normal + damping * (np.diag(np.diag(normal)) + 1e-9 * np.eye(len(normal)))
        move = np.asarray(-np.linalg.lstsq(damped, jacobian.T @ robust(state.z), rcond=None)[0], float)
        length = float(np.abs(move).max())
        move *= min(1.0, reach / max(length, 1e-9))
        refused = _refused(state, move) & ~held
        if not refused.any():
            return move, length
        held |= refused


def _refused(state: _State, move: NDArray[np.float64]) -> NDArray[np.bool_]:
    """(P,) which parameters a move leads, each by itself, to where effects refuse them."""
    theta, moved = theta_of(state.hypothesis), move * state.steps
    if is_allowed(with_theta(state.hypothesis, theta + moved)):
        return np.zeros(len(move), bool)
    alone = theta + np.diag(moved)
    return np.array([not is_allowed(with_theta(state.hypothesis, each)) for each in alone])


def _first_promise(state: _State) -> float:
    return _promised(state, _move(state, state.damping, state.reach)[0])


def _promised(state: _State, move: NDArray[np.float64]) -> float:
    """Gain of a step if the Jacobian is right: where that is nothing, it needs no simulation."""
    straight = robust(state.z)
    return float(np.sum(straight**2) - np.sum((straight + state.jacobian @ move) ** 2))


def _improved(problem: Problem, state: _State, worth: float) -> _State | None:
    """A better point, trying ever shorter steps as long as they promise to be worth it; None if none is."""
    theta, straight = theta_of(state.hypothesis), robust(state.z)
    damping, reach = state.damping, state.reach
    for _ in range(TRIES):
        move, length = _move(state, damping, reach)
        if _promised(state, move) < worth:
            return None
        candidate = with_theta(state.hypothesis, theta + move * state.steps)
        changed = problem.residual(candidate)
        if changed is not None and _cost(changed) < _cost(state.z):
            jacobian, is_exact = state.jacobian, state.is_exact
            if (size := float(np.linalg.norm(move))) >= STEP:  # what a shorter one shows is rounding of codes
                missed = robust(changed) - straight - jacobian @ move
                jacobian, is_exact = jacobian + np.outer(missed, move) / size**2, False
            farther = 2 * reach if length > reach else max(reach, 1.0)
            return _State(candidate, changed, jacobian, state.steps, damping / 3, farther, is_exact)
        damping = max(damping * 10, 0.1)
        reach = min(reach, length) / 3
    return None


def _held_out(
    problem: Problem,
    hypothesis: Hypothesis,
    z: NDArray[np.float64],
    jacobian: NDArray[np.float64],
    steps: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Residuals of each fold with the parameters the other fold alone would have chosen, to first order.

    A number that stands alone was fitted to; it counts with what that flatters it by, twice its leverage
    (Mallows 1973, "Some comments on Cp", Technometrics 15(4)).
    """
    if not jacobian.shape[1]:
        return z
    straight, predicted = robust(z), z.copy()
    alone = np.ones(len(z), bool)
    for held in held_parts_for(problem, hypothesis):
        move = _move_without(held, hypothesis, straight, jacobian, steps)
        predicted[held] += jacobian[held] @ move / robust_derivative(z[held])
        alone &= ~held
    own = jacobian[alone]
    leverage = np.sum(own * np.linalg.solve(_ridged(jacobian), own.T).T, axis=1)
    honest = np.copysign(np.sqrt(straight[alone] ** 2 + 2 * leverage), straight[alone])
    predicted[alone] = ROBUST_SCALE * np.sinh(honest / ROBUST_SCALE)
    return predicted


def move_without(fitted: Fitted, held: NDArray[np.bool_]) -> NDArray[np.float64]:
    """(P,) the move that all numbers but those held out would choose [steps that matter]."""
    if not len(fitted.steps):
        return np.zeros(0)
    return _move_without(held, fitted.hypothesis, robust(fitted.z), fitted.jacobian, fitted.steps)


def _move_without(
    held: NDArray[np.bool_],
    hypothesis: Hypothesis,
    straight: NDArray[np.float64],
    jacobian: NDArray[np.float64],
    steps: NDArray[np.float64],
) -> NDArray[np.float64]:
    return _within_bounds(hypothesis, move_of_fold(jacobian[~held], straight[~held]), steps)


def held_parts_for(problem: Problem, hypothesis: Hypothesis) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """`Problem.held_parts`, within captures where a capture has values of its own."""
    by_capture = any(is_of_one_capture(name) for name in free_names(hypothesis))
    return problem.held_parts(within_captures=by_capture)


def move_of_fold(jacobian: NDArray[np.float64], straight: NDArray[np.float64]) -> NDArray[np.float64]:
    """(P[, D]) the move that residuals of one fold would choose, at most two steps [steps that matter].

    `jacobian`: (K, P) changes of those residuals with each parameter. `straight`: (K[, D]) the residuals,
    made robust.
    """
    return np.clip(-np.linalg.solve(_ridged(jacobian), jacobian.T @ straight), -2, 2)


def _ridged(jacobian: NDArray[np.float64]) -> NDArray[np.float64]:
    """(P, P) normal matrix of parameters that are known to a step that matters."""
    normal = jacobian.T @ jacobian
    ridge = 1e-6 * max(float(np.trace(normal)) / len(normal), 1e-12)
    return np.asarray(normal + (ridge + 1.0) * np.eye(len(normal)))


def _within_bounds(
    hypothesis: Hypothesis, move: NDArray[np.float64], steps: NDArray[np.float64]
) -> NDArray[np.float64]:
    """As much of a move as the effects allow: no camera is predicted that none of them could be."""
    theta = theta_of(hypothesis)
    for share in (1.0, 0.5, 0.25, 0.125):
        if is_allowed(with_theta(hypothesis, theta + share * move * steps)):
            return share * move
    return np.zeros_like(move)
