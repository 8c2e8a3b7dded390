"""Intervals of the parameters of an explanation.

Three things move an estimate above all: the noise of the captures and of the simulations they are compared
with, which the hypothesis' own replicates show; formulas that are not quite the camera's, which show where
captures, or statistics of a capture, disagree by more than noise; and what little of a formula's error no
capture shows. Their variances add, and that of maps: each sensor, real or simulated, is one draw of them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from tacos_gap.evidence import PictureEvidence
from tacos_gap.hypotheses.parameters import HypothesisTerm, initial_guesses_of
from tacos_gap.inference.fit import Fitted
from tacos_gap.inference.jacobian import jacobian_at
from tacos_gap.inference.problem import Hypothesis, Problem, robust, robust_derivative
from tacos_gap.inference.unknown import block_index

PRIOR = 0.1
"""Precision of a parameter that nothing bears on: it stays within some steps that matter [1 / step^2]."""

UNSEEN = 0.0125
"""Share of what the explanation changed in a statistic that its formula may miss unseen, alike in all
captures: so far apart are makers of an effect that share no formula (docs/how-to/check_the_diagnosis.md)."""

FEWEST = 2.0
"""Degrees of freedom of a spread between captures at least: with fewer its own luck would rule."""


def half_widths(problem: Problem, fitted: Fitted, confidence: float = 0.9) -> NDArray[np.float64]:
    """Half of each free parameter's interval.

    Parameters that were put back to neutral for want of evidence are uncertain too, and make others so.

    - `fitted`: the explanation, where its fit ended.

    Returns: (P,) in the parameters' units; finite and above 0.
    """
    if not len(fitted.steps):
        return np.zeros(0)
    every = of_every_parameter(problem, fitted, confidence)
    return every.half_width[_kept(fitted.hypothesis, every.hypothesis)]


@dataclass(frozen=True, eq=False)
class EveryParameter:
    """All parameters of an explanation, those put back to neutral among them."""

    hypothesis: Hypothesis  # the explanation with all of them free
    half_width: NDArray[np.float64]  # (P,) half of each one's interval, in the parameters' units
    move: NDArray[np.float64]
    """(P,) how far they would move if they were fitted together, to first order, likewise."""


def of_every_parameter(problem: Problem, fitted: Fitted, confidence: float = 0.9) -> EveryParameter:
    """Intervals of all parameters of an explanation that has some; see `half_widths`."""
    hypothesis = tuple(_all_free(term) for term in fitted.hypothesis)
    jacobian, steps = jacobian_at(problem, hypothesis)
    noise, replicates = noise_variance(problem, fitted, jacobian)
    captures = [np.arange(slot.start, slot.stop) for slot in problem.slots if slot.stop > slot.start]
    blocks = block_index(problem)
    statistics = [np.flatnonzero(blocks == k) for k in range(int(blocks.max(initial=-1)) + 1)]
    spreads = [spread_between(groups, fitted.z, jacobian) for groups in (captures, statistics)]
    excess, freedom = _larger_excess(spreads, noise)
    unseen = unseen_variance(fitted.z - problem.null, _in_all_captures(problem), jacobian)
    variance = noise + excess + unseen + map_variance(problem, hypothesis) / steps**2
    own = np.maximum(noise**2 / (replicates - 1) + excess**2 / freedom, 1e-300)
    quantile = stdtrit(np.clip((noise + excess) ** 2 / own, FEWEST, 1e6), 0.5 + confidence / 2)
    move = -_estimator(jacobian)[0] @ robust(fitted.z)
    return EveryParameter(hypothesis, quantile * np.sqrt(variance) * steps, move * steps)


def noise_variance(
    problem: Problem, fitted: Fitted, jacobian: NDArray[np.float64]
) -> tuple[NDArray[np.float64], int]:
    """(P,) variance of the estimates by noise, and how many replicates tell it [step^2].

    That of the captures, as the replicates of the hypothesis show it, and of the mean of the simulations
    they are compared with.
    """
    residuals = problem.replicate_residuals(fitted.hypothesis)
    floor = residuals.replicates * (residuals.scale / problem.scale) * robust_derivative(fitted.z)
    estimator, inverse = _estimator(jacobian)
    moves = floor @ estimator.T
    of_captures = (moves**2).sum(axis=0) / (len(floor) - 1)
    return of_captures * (1 + 1 / fitted.draws) + PRIOR * np.sum(inverse**2, axis=1), len(floor)


def spread_between(
    groups: list[NDArray[np.int64]], z: NDArray[np.float64], jacobian: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(P,) variance of the estimates by leaving out each group in turn, to first order, and its degrees of
    freedom.

    Groups count as far as they bear on a parameter: of ten captures of which two do there are two.

    Source: Efron & Tibshirani 1993, "An Introduction to the Bootstrap", Eq. 11.5; Kish 1965, "Survey
    Sampling": the effective number.
    """
    estimator, _ = _estimator(jacobian)
    everything = jacobian.T @ jacobian
    gradient = jacobian.T @ robust(z)
    moves, shares = [], []
    for group in groups:
        own = jacobian[group]
        left = everything - own.T @ own + _ridge(everything)
        moves.append(-np.linalg.lstsq(left, gradient - own.T @ robust(z[group]), rcond=None)[0])
        shares.append(
            np.maximum(np.sum(estimator[:, group] * own.T, axis=1), 0.0)
        )  # of what is known of each
    share = np.array(shares) / np.maximum(np.sum(shares, axis=0), 1e-300)
    effective = 1 / np.maximum(np.sum(share**2, axis=0), 1 / len(groups))
    spread = np.array(moves) - np.mean(moves, axis=0)
    variance = (effective - 1) / effective * (spread**2).sum(axis=0)
    return np.asarray(variance), np.asarray(np.maximum(effective - 1, FEWEST))


def unseen_variance(
    change: NDArray[np.float64], statistics: list[NDArray[np.int64]], jacobian: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(P,) variance of estimates where each statistic is wrong by a share of its (K,) change [step^2]."""
    estimator, _ = _estimator(jacobian)
    moves = np.array([estimator[:, own] @ change[own] for own in statistics])
    return np.asarray(UNSEEN**2 * (moves**2).sum(axis=0))


def _in_all_captures(problem: Problem) -> list[NDArray[np.int64]]:
    """Numbers of each statistic in all captures: a formula is wrong in all alike."""
    names = np.array([label.statistic for label in problem.labels])
    return [np.flatnonzero(names == name) for name in dict.fromkeys(names.tolist())]


def map_variance(problem: Problem, hypothesis: Hypothesis) -> NDArray[np.float64]:
    """(P,) variance of spreads by the luck of their maps, which all captures of a sensor share.

    The standard deviation of n normal numbers varies by the share 1 / sqrt(2 n); the camera's map and the
    simulated one do so both. Spreads over columns have as many numbers as there are columns.
    """
    shapes = [e.capture.valid.shape for e in problem.evidence if isinstance(e, PictureEvidence)]
    if not shapes:
        return np.zeros(sum(len(term.free) for term in hypothesis))
    rows, columns = max(shapes, key=lambda shape: shape[0] * shape[1])
    variance = []
    for term in hypothesis:
        has_map = "map_seed" in term.cls.Config.model_fields
        for name, value in zip(term.free, term.theta, strict=True):
            count = columns if name.startswith("column_") else rows * columns
            variance.append(value**2 / count if has_map else 0.0)
    return np.array(variance)


def _larger_excess(
    spreads: list[tuple[NDArray[np.float64], NDArray[np.float64]]], noise: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(P,) what groups disagree by beyond noise, by the groups that show more, and its degrees of freedom."""
    variance, freedom = (np.stack(part) for part in zip(*spreads, strict=True))
    larger = np.argmax(variance, axis=0), np.arange(len(noise))
    return np.maximum(variance[larger] - noise, 0.0), freedom[larger]


def _estimator(jacobian: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(P, K) least squares as a matrix, and the (P, P) inverse of its normal equations."""
    normal = jacobian.T @ jacobian
    inverse = np.linalg.pinv(normal + _ridge(normal), hermitian=True)
    return np.asarray(inverse @ jacobian.T), np.asarray(inverse)


def _ridge(normal: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray((1e-9 * float(np.trace(normal)) / len(normal) + PRIOR) * np.eye(len(normal)))


def _all_free(term: HypothesisTerm) -> HypothesisTerm:
    begun = {
        name: step for start in initial_guesses_of(term.name, term.cls) for name, step in start.free.items()
    }
    freed = {name: step for name, step in begun.items() if name in term.values and name not in term.free}
    return replace(term, free={**term.free, **freed})


def _kept(narrow: Hypothesis, wide: Hypothesis) -> list[int]:
    """Parameters of the wider hypothesis that are free in the narrower one, in its order."""
    start, found = 0, []
    for few, many in zip(narrow, wide, strict=True):
        names = list(many.free)
        found += [start + names.index(name) for name in few.free]
        start += len(names)
    return found
