"""How well the captures settle the parameters of an explanation.

Two things move an estimate: noise, which the hypothesis' own replicates show, and formulas that are not quite
the camera's, which show when captures disagree. The larger of the two counts.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from tacos_gap.evidence import SPREAD_OF_ONE
from tacos_gap.fit import Fitted, jacobian_at
from tacos_gap.parameters import HypothesisTerm, initial_guesses_of
from tacos_gap.problem import Hypothesis, Problem, robust, robust_derivative


def half_widths(problem: Problem, fitted: Fitted, confidence: float = 0.9) -> NDArray[np.float64]:
    """Half of each free parameter's interval.

    Parameters that were put back to neutral for want of evidence are uncertain too, and make others so.

    Parameters
    ----------
    problem
        The evidence.
    fitted
        The explanation, where its fit ended.
    confidence
        Probability of the intervals.

    Returns
    -------
    NDArray
        (P,) in the parameters' units.
    """
    if not len(fitted.steps):
        return np.zeros(0)
    hypothesis = tuple(_all_free(term) for term in fitted.hypothesis)
    jacobian, steps = jacobian_at(problem, hypothesis)
    noise, replicates = noise_variance(problem, fitted, jacobian)
    variance = np.maximum(noise, jackknife_variance(problem, fitted.z, jacobian))
    quantile = float(stdtrit(replicates - 1, 0.5 + confidence / 2))
    return np.asarray((quantile * np.sqrt(variance) * steps)[_kept(fitted.hypothesis, hypothesis)])


def noise_variance(
    problem: Problem, fitted: Fitted, jacobian: NDArray[np.float64]
) -> tuple[NDArray[np.float64], int]:
    """(P,) variance of the estimates over replicates of the hypothesis, and how many there are [step^2]."""
    residuals = problem.replicate_residuals(fitted.hypothesis)
    floor = residuals.replicates * (residuals.scale / problem.scale) * robust_derivative(fitted.z)
    moves = floor @ _estimator(jacobian).T
    return SPREAD_OF_ONE * (moves**2).sum(axis=0) / (len(floor) - 1), len(floor)


def jackknife_variance(
    problem: Problem, z: NDArray[np.float64], jacobian: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(P,) variance of the estimates by leaving out each capture in turn, to first order [step^2].

    References
    ----------
    Efron & Tibshirani 1993, "An Introduction to the Bootstrap", Eq. 11.5.
    """
    slots = [slot for slot in problem.slots if slot.stop > slot.start]
    moves = []
    for slot in slots:
        kept = np.ones(len(z), bool)
        kept[slot.start : slot.stop] = False
        moves.append(-_estimator(jacobian[kept]) @ robust(z[kept]))
    spread = np.array(moves) - np.mean(moves, axis=0)
    return np.asarray((len(slots) - 1) / len(slots) * (spread**2).sum(axis=0))


def _estimator(jacobian: NDArray[np.float64]) -> NDArray[np.float64]:
    """(P, K) least squares as a matrix; what no number bears on stays within some steps that matter."""
    normal = jacobian.T @ jacobian
    ridge = 1e-9 * float(np.trace(normal)) / len(normal) + 0.1
    return np.asarray(np.linalg.solve(normal + ridge * np.eye(len(normal)), jacobian.T))


def _all_free(term: HypothesisTerm) -> HypothesisTerm:
    """The term with those parameters free again that its search began with."""
    begun = {
        name: step for start in initial_guesses_of(term.name, term.cls) for name, step in start.free.items()
    }
    freed = {name: step for name, step in begun.items() if name in term.values and name not in term.free}
    return replace(term, free={**term.free, **freed})


def _kept(narrow: Hypothesis, wide: Hypothesis) -> list[int]:
    """Which parameters of the wider hypothesis are free in the narrower one, in its order."""
    start, found = 0, []
    for few, many in zip(narrow, wide, strict=True):
        names = list(many.free)
        found += [start + names.index(name) for name in few.free]
        start += len(names)
    return found
