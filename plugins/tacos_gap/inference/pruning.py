"""Parameters that are not needed go back to neutral, so that the others mean what they say."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tacos_gap.hypotheses.by_capture import is_of_one_capture
from tacos_gap.hypotheses.parameters import HypothesisTerm, neutral_value, series_of
from tacos_gap.inference.fit import Fitted, finished, fit, settled
from tacos_gap.inference.intervals import of_every_parameter
from tacos_gap.inference.problem import Hypothesis, Problem, robust

WOULD_MOVE = 0.5
"""Share of its interval by which a parameter would leave neutral, from which on it is tried."""

REFITTED = 2
"""How many candidates for going are tried, the least missed first."""

PLAINLY = 10.0
"""Times what an effect or a parameter must be worth that it is worth to first order, from which on no fit
without it is tried."""


def pruned(problem: Problem, fitted: Fitted, least: float) -> Fitted:
    """A fit without the parameters that are worth less than `least` each on held-out conditions [nat]."""
    while True:
        less = _with_one_less(problem, fitted, least)
        begun = [fit(problem, hypothesis, near=fitted) for hypothesis in less]
        fewer = [settled(problem, f) for f in begun if f is not None]
        kept = [f for f in fewer if f.score > fitted.score - least]
        if not kept:
            return fitted
        fitted = max(kept, key=lambda f: f.score)


def restored(problem: Problem, fitted: Fitted, least: float) -> Fitted:
    """A finished fit with parameters free again that are worth `least` on held-out conditions [nat].

    Where much is explained, a parameter goes that gains a small share of it, though captures show it; the
    others then take its part, and miss by many of their intervals.
    """
    if not len(fitted.steps):
        return fitted
    every = of_every_parameter(problem, fitted)
    column, hypothesis = 0, []
    for term, wide in zip(fitted.hypothesis, every.hypothesis, strict=True):
        free = dict(term.free)
        for name, step in wide.free.items():
            if name not in free and abs(every.move[column]) > WOULD_MOVE * every.half_width[column]:
                free[name] = step
            column += 1
        hypothesis.append(replace(term, free=free))
    if (
        tuple(hypothesis) == fitted.hypothesis
        or (begun := fit(problem, tuple(hypothesis), near=fitted)) is None
    ):
        return fitted
    wider = finished(problem, begun)
    return wider if wider.score > fitted.score + least else fitted


def _is_of_a_whole(name: str) -> bool:
    """True if a parameter stays free with others: an entry of a matrix or curve, the value of one capture."""
    return "." in name or is_of_one_capture(name)


def _carries_more(term: HypothesisTerm, name: str) -> bool:
    """True if a higher coefficient of its series is free."""
    series = series_of(term.cls, name)
    return not term.free.keys().isdisjoint(series[series.index(name) + 1 :] if series else ())


def _with_one_less(problem: Problem, fitted: Fitted, least: float) -> list[Hypothesis]:
    """The hypothesis with one parameter at neutral for good, of those that are not plainly needed.

    Those that to first order are missed least. `least`: what a parameter must be worth [nat].
    """
    found: list[tuple[float, Hypothesis]] = []
    column = 0
    straight = robust(fitted.z)
    for position, term in enumerate(fitted.hypothesis):
        for name in term.free:
            k, column = column, column + 1
            neutral = neutral_value(term.cls, name)
            movable = [n for n in term.free if neutral_value(term.cls, n) is not None]
            if neutral is None or len(movable) < 2 or _is_of_a_whole(name) or _carries_more(term, name):
                continue
            others = np.delete(fitted.jacobian, k, axis=1)
            moved = straight + fitted.jacobian[:, k] * (neutral - term.values[name]) / fitted.steps[k]
            moved = moved - others @ np.linalg.lstsq(others, moved, rcond=None)[0]
            values = {**term.values, name: neutral}
            free = {n: step for n, step in term.free.items() if n != name}
            fewer = list(fitted.hypothesis)
            fewer[position] = replace(term, values=values, free=free)
            worth = 0.5 * problem.weight * float(np.sum(moved**2) - np.sum(straight**2))
            if worth < PLAINLY * least:
                found.append((worth, tuple(fewer)))
    return [hypothesis for _, hypothesis in sorted(found, key=lambda pair: pair[0])[:REFITTED]]
