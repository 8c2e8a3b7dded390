"""Other forms of an effect at its initial guesses: points of a curve for an exponent, a value per capture."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from tacos_gap.hypotheses.by_capture import captures_with_values, setting_of
from tacos_gap.hypotheses.parameters import HypothesisTerm
from tacos_gap.inference.fit import Fitted, fit, settled
from tacos_gap.inference.problem import Hypothesis, Problem, robust


def in_its_best_form(
    problem: Problem, fitted: Fitted, guesses: Iterable[HypothesisTerm], worth: float
) -> Fitted:
    *rest, term = fitted.hypothesis
    forms: dict[frozenset[str], list[HypothesisTerm]] = {}
    for guess in guesses:
        if _is_another_form(guess, term):
            forms.setdefault(frozenset(guess.free), []).append(guess)
    best = fitted
    for alike in forms.values():
        starts = [(_cost(problem, (*rest, guess)), guess) for guess in alike]
        begun = fit(problem, (*rest, min(starts, key=lambda start: start[0])[1]), near=fitted)
        if begun is None:
            continue
        other = settled(problem, begun)
        more = max(_settings(other) - _settings(best), 0)  # values of single captures pay in the score
        if other.score > best.score + worth * more:
            best = other
    return best


def _is_another_form(guess: HypothesisTerm, term: HypothesisTerm) -> bool:
    """True if it has settings that the term lacks: several, or one in place of a value for each capture."""
    return not set(guess.free) <= set(term.values) and (
        len(guess.free) > 1 or bool(captures_with_values(term.values))
    )


def _settings(fitted: Fitted) -> int:
    return len({setting_of(name) for name in fitted.hypothesis[-1].free})


def _cost(problem: Problem, hypothesis: Hypothesis) -> float:
    z = problem.residual(hypothesis)
    return np.inf if z is None else float(np.sum(robust(z) ** 2))
