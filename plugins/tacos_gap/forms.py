"""Other forms of an effect, as a curve along points in place of an exponent, at its own initial guesses."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from tacos_gap.fit import Fitted, fit, settled
from tacos_gap.parameters import HypothesisTerm
from tacos_gap.problem import Hypothesis, Problem, robust


def in_its_best_form(
    problem: Problem, fitted: Fitted, guesses: Iterable[HypothesisTerm], worth: float
) -> Fitted:
    """A fit whose last effect has the form that predicts best.

    Parameters
    ----------
    problem
        The evidence.
    fitted
        The fit.
    guesses
        Initial guesses of that effect; those with other free parameters than the fit has are other forms.
    worth
        What each parameter more must gain in log score on held-out conditions [nat].
    """
    *rest, term = fitted.hypothesis
    forms: dict[frozenset[str], list[HypothesisTerm]] = {}
    for guess in guesses:
        if len(guess.free) > 1 and not set(guess.free) <= set(term.values):
            forms.setdefault(frozenset(guess.free), []).append(guess)
    best = fitted
    for alike in forms.values():
        starts = [(_cost(problem, (*rest, guess)), guess) for guess in alike]
        begun = fit(problem, (*rest, min(starts, key=lambda start: start[0])[1]))
        if begun is None:
            continue
        other = settled(problem, begun)
        more = max(len(other.hypothesis[-1].free) - len(best.hypothesis[-1].free), 0)
        if other.score > best.score + worth * more:
            best = other
    return best


def _cost(problem: Problem, hypothesis: Hypothesis) -> float:
    z = problem.residual(hypothesis)
    return np.inf if z is None else float(np.sum(robust(z) ** 2))
