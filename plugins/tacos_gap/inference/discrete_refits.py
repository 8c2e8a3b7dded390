"""Discrete settings of a finished explanation, tried anew: they were chosen when less was known."""

from __future__ import annotations

from tacos_gap.inference.discrete import searched, with_other_words
from tacos_gap.inference.fit import DRAWS, Fitted, finished, fit
from tacos_gap.inference.problem import Problem, without


def to_the_digit(problem: Problem, fitted: Fitted) -> Fitted:
    """A fit whose discrete settings are the best of their neighbours, by several simulations."""
    averaged = problem.averaging(max(DRAWS, problem.draws))
    hypothesis = fitted.hypothesis
    for name in fitted.names:
        term = next(term for term in hypothesis if term.name == name)
        hypothesis = searched(averaged, (*without(hypothesis, name), term), farthest=1)
    if {term.name: term for term in hypothesis} == {term.name: term for term in fitted.hypothesis}:
        return fitted
    begun = fit(problem, hypothesis, near=fitted)
    return fitted if begun is None else max(fitted, finished(problem, begun), key=lambda f: f.score)


def in_other_words(problem: Problem, fitted: Fitted, worth: float) -> Fitted:
    """A fit with another word in one setting, as for a way of rounding, where all else fits better.

    Effects that came later may stand in for the right one: a darker exposure for half a code.

    `worth`: what the other word must gain in log score [nat].
    """
    found, least = [], fitted.score + worth
    for term in fitted.hypothesis:
        for other in with_other_words(term):
            begun = fit(problem, (*without(fitted.hypothesis, term.name), other), near=fitted)
            if begun is not None and begun.score > least:
                found.append(finished(problem, begun))
    best = max(found, key=lambda each: each.score, default=fitted)
    return best if best.score > least else fitted
