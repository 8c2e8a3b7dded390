"""Shortlist: the effects that to first order gain most, each from its best initial guess."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tacos_gap.hypotheses.parameters import HypothesisTerm
from tacos_gap.inference.fit import Fitted
from tacos_gap.inference.problem import Hypothesis, Problem, robust
from tacos_gap.inference.screening import ScreeningDirections, screening_score


def shortlist(
    problem: Problem,
    directions: ScreeningDirections,
    base: Fitted,
    names: Sequence[str],
    *,
    count: int,
    least: float = 0.0,
) -> list[HypothesisTerm]:
    """Initial guesses of the effects with the highest screening scores on `base`, the highest first.

    `least`: screening score below which an effect is not fitted [nat].
    """
    scores = sorted((screening_score(directions[name], base.z) for name in names), key=lambda s: -s.gain)
    worth = 0.5 * problem.weight
    kept = [score.initial_guesses for score in scores[:count] if worth * score.gain > least]
    return [_nearest(problem, base.hypothesis, guesses) for guesses in kept]


def _nearest(problem: Problem, rest: Hypothesis, guesses: Sequence[HypothesisTerm]) -> HypothesisTerm:
    """The guess that leaves least once it is simulated: what adds up to first order need not."""

    def left(guess: HypothesisTerm) -> float:
        z = problem.residual((*rest, guess))
        return np.inf if z is None else float(np.sum(robust(z) ** 2))

    return guesses[0] if len(guesses) == 1 else min(guesses, key=left)
