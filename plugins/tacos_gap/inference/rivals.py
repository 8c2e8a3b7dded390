"""Certainty that one effect predicts better than another: a score difference and its standard error."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from tacos_gap.evidence import SPREAD_OF_ONE
from tacos_gap.inference.fit import Fitted, squares_in_own_units
from tacos_gap.inference.problem import Problem, robust
from tacos_gap.inference.unknown import block_index


def standard_error(problem: Problem, one: Fitted, other: Fitted) -> float:
    """Standard error of the difference between two log scores [nat].

    Noise moves both scores, and their difference only as far as their predictions differ. It counts as
    often as numbers vary together, and more in blocks that even the better one does not describe: what a
    formula misses there could as well lean to the other side. So could what is negligible: all numbers of a
    block may be off by their equivalence margins together, however little noise there is.

    Source: Vuong 1989, "Likelihood ratio tests for model selection and non-nested hypotheses", Econometrica
    57(2); McCullagh & Nelder 1989, "Generalized Linear Models", Sec. 4.5: overdispersion.
    """
    if not len(one.z):
        return 0.0
    blocks = block_index(problem)
    better, worse = sorted((one, other), key=lambda fitted: -fitted.score)
    apart = robust(better.held_out) - robust(worse.held_out)
    left = np.bincount(blocks, robust(better.held_out) ** 2) / np.bincount(blocks)
    by_noise = problem.weight * float(np.sum(np.bincount(blocks, apart**2) * np.maximum(left, 1.0)))
    by_margins = problem.weight * np.bincount(blocks, np.abs(apart) * _margins(problem, blocks))
    return math.sqrt(by_noise + float(np.sum(by_margins**2)))


def _margins(problem: Problem, blocks: NDArray[np.int64]) -> NDArray[np.float64]:
    """(K,) equivalence margins: what the noise of the simulator's replicates lacks of the units [1]."""
    by_noise = SPREAD_OF_ONE * np.bincount(blocks, problem.null_replicates.var(axis=0)) / np.bincount(blocks)
    return np.asarray(np.sqrt(np.clip(1 - by_noise, 0.0, 1.0)))[blocks]


def slot_probabilities(scores: Mapping[str, float], errors: Mapping[str, float]) -> dict[str, float]:
    """Probability of each effect in one place of the explanation.

    The odds against the best are the mean odds over the uncertainty of the difference, so that a rival
    within two standard errors is never ruled out.

    - `errors`: standard error of each score's difference to that of the effect itself [nat]; 0 where missing.

    Source: MacKay 1992, "The evidence framework applied to classification networks", Neural Computation 4(5),
    Eq. 10: a logistic function averaged over a Gaussian.

    >>> {name: round(p, 3) for name, p in slot_probabilities({"a": 0.0, "b": -8.0}, {}).items()}
    {'a': 1.0, 'b': 0.0}
    >>> {name: round(p, 3) for name, p in slot_probabilities({"a": 0.0, "b": -8.0}, {"b": 6.0}).items()}
    {'a': 0.887, 'b': 0.113}
    """
    if not scores:
        return {}
    best = max(scores, key=lambda name: scores[name])
    odds = {}
    for name, score in scores.items():
        error = math.hypot(errors.get(name, 0.0), errors.get(best, 0.0)) if name != best else 0.0
        odds[name] = math.exp(max((score - scores[best]) / math.sqrt(1 + math.pi * error**2 / 8), -700.0))
    total = sum(odds.values())
    return {name: value / total for name, value in odds.items()}


def discrepancy(problem: Problem, base: Fitted, share: float) -> NDArray[np.float64]:
    """(B,) what the formulas of an explanation may leave in each block, as they are not quite the camera's.

    A coherent `share` of what the explanation changed there [squared noise floor].
    """
    changed = (problem.null - base.z) / problem.own_units(base.names)
    return np.asarray(share**2 * np.bincount(block_index(problem), changed**2))


def gain_beyond(problem: Problem, base: Fitted, fitted: Fitted, allowed: NDArray[np.float64]) -> float:
    """Gain of a fit over another in log score, in each block beyond an allowance of (B,) squares [nat]."""
    blocks = block_index(problem)
    fell = (squares_in_own_units(problem, each.names, each.held_out) for each in (base, fitted))
    gain = np.bincount(blocks, np.subtract(*fell), len(allowed))
    return 0.5 * problem.weight * float(np.sum(np.sign(gain) * np.maximum(np.abs(gain) - allowed, 0.0)))
