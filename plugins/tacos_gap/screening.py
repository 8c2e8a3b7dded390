"""Which effects look promising: every effect tried once at the severities it names.

What a trial changes in the residuals is kept as a direction: rounds are screened without simulating anew.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_gap.evidence import ImageEvidence
from tacos_gap.fit import theta_of
from tacos_gap.parameters import Term, terms_for
from tacos_gap.problem import Problem, bent, slope

SHARES = (0.15, 0.4, 0.7, 1.0, 1.6, 2.5)
"""Multiples of a trial's change that are looked at."""

Map = Callable[[Callable[[Term], Any], Iterable[Term]], Iterable[Any]]


@dataclass(frozen=True, eq=False)
class Trial:
    """An effect at a start: what it changes in the residuals."""

    term: Term
    change: NDArray[np.float64]


Trials = Mapping[str, Sequence[Trial]]
"""The trials of each effect by its name; effects that change nothing are left out."""


@dataclass(frozen=True, eq=False)
class Promise:
    """How much an effect could gain, to first order.

    Parameters
    ----------
    gain
        Fall of the sum of bent squares.
    start
        Where its fit should begin.
    """

    gain: float
    start: Term


def try_all(problem: Problem, effects: Mapping[str, type[Any]], each: Map = map) -> Trials:
    """Simulate each effect at each of its starts; `each` is a map that may work in parallel."""
    captures = [each.capture for each in problem.evidence if isinstance(each, ImageEvidence)]
    terms = [term for name, cls in effects.items() for term in terms_for(name, cls, captures)]
    found: dict[str, list[Trial]] = {}
    for term, z in zip(terms, each(lambda term: problem.residual((term,)), terms), strict=True):
        if z is not None and not np.array_equal(z, problem.null):
            found.setdefault(term.name, []).append(Trial(term, z - problem.null))
    return found


def in_units(trials: Trials, factor: NDArray[np.float64]) -> Trials:
    """The trials with residuals multiplied by (K,) `factor`."""
    return {
        name: [Trial(trial.term, trial.change * factor) for trial in of_effect]
        for name, of_effect in trials.items()
    }


def promise(trials: Sequence[Trial], base: NDArray[np.float64]) -> Promise:
    """What an effect could gain on top of (K,) residuals.

    Each trial is scaled along its own direction; trials of one parameter each are also combined, and a fit
    that begins at one of them has them all free.
    """
    cost = float(np.sum(bent(base) ** 2))
    best = Promise(-np.inf, trials[0].term)
    single = _of_one_parameter(trials)
    for trial in trials:
        for share in SHARES if trial.term.free else (1.0,):  # discrete effects are there or not
            gain = cost - float(np.sum(bent(base + share * trial.change) ** 2))
            if gain > best.gain:
                best = Promise(gain, _scaled(trial.term, share))
    if not single:
        return best
    combined = _combined(single, base)
    if combined is not None and combined.gain > best.gain:
        return combined
    return replace(best, start=_with_all_free(best.start, single))


def starts_of_all(trials: Sequence[Trial]) -> list[Term]:
    """Where fits of an effect can begin, one for each trial."""
    single = _of_one_parameter(trials)
    return [_with_all_free(trial.term, single) for trial in trials]


def _of_one_parameter(trials: Sequence[Trial]) -> Mapping[str, Trial]:
    """Trials with one free parameter, by its name; none where there are not several, or they are few."""
    single = {next(iter(trial.term.free)): trial for trial in trials if len(trial.term.free) == 1}
    return {} if len(single) < 2 or len(single) < len(trials) / 2 else single


def _with_all_free(term: Term, single: Mapping[str, Trial]) -> Term:
    """The term with the parameters of other trials free too, from neutral on."""
    if len(term.free) != 1 or not single:
        return term
    values = {name: _scaled(trial.term, 0.0).values[name] for name, trial in single.items()}
    steps = {name: trial.term.free[name] for name, trial in single.items()}
    wider = replace(term, values={**values, **term.values}, free={**steps, **term.free})
    return wider if wider.placed() is not None else term


def _combined(single: Mapping[str, Trial], base: NDArray[np.float64]) -> Promise | None:
    """Trials of one free parameter each, combined by least squares."""
    trials = list(single.values())
    directions = np.stack([trial.change for trial in trials], axis=1)
    weights = slope(base)
    normal = (directions * weights[:, None]).T @ directions
    ridge = 1e-4 * float(np.trace(normal)) / len(normal)
    shares = -np.linalg.solve(normal + ridge * np.eye(len(normal)), directions.T @ (weights * base))
    shares = np.clip(shares, -4, 4)
    values: dict[str, Any] = {}
    free: dict[str, float] = {}
    for (key, trial), share in zip(single.items(), shares, strict=True):
        values |= {**trial.term.values, key: _scaled(trial.term, float(share)).values[key]}
        free[key] = trial.term.free[key]
    term = replace(trials[0].term, values=values, free=free)
    if term.placed() is None:
        return None
    gain = float(np.sum(bent(base) ** 2)) - float(np.sum(bent(base + directions @ shares) ** 2))
    return Promise(gain, term)


def _scaled(term: Term, scale: float) -> Term:
    """A term with its free parameters moved to `scale` times their distance from neutral."""
    if not term.free or scale == 1.0:
        return term
    neutral = {key: float(value) for key, value in term.cls.neutral.items() if isinstance(value, float)}
    theta = theta_of((term,))
    moved = []
    for key, value in zip(term.free, theta, strict=True):
        at = 0.0 if key.startswith("matrix.") else neutral.get(key)
        moved.append(value if at is None else at + scale * (value - at))
    changed = term.with_free(moved)
    return changed if changed.placed() is not None else term
