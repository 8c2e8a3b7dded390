"""Screening of effects: every one simulated once at each of its initial guesses, and scored to first order.

What each changes in the residuals is kept as a direction: rounds are screened without simulating anew.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_gap.evidence import PictureEvidence
from tacos_gap.evidence.boards import BoardEvidence
from tacos_gap.hypotheses.parameters import HypothesisTerm, initial_guesses_for, neutral_value
from tacos_gap.inference.jacobian import theta_of
from tacos_gap.inference.problem import Problem, robust, robust_derivative

SHARES = (0.15, 0.4, 0.7, 1.0, 1.6, 2.5)
"""Multiples of a direction's change that are looked at."""


RIDGE = 1e-4
"""Added to the mean square of directions that are combined, so that two that are alike can be solved for."""


@dataclass(frozen=True, eq=False)
class ScreeningDirection:
    term: HypothesisTerm
    change: NDArray[np.float64]


ScreeningDirections = Mapping[str, Sequence[ScreeningDirection]]
"""The directions of each effect by its name; effects that change nothing are left out."""


@dataclass(frozen=True, eq=False)
class ScreeningScore:
    """Screening score: how much an effect could gain, to first order."""

    gain: float  # fall of the sum of robust squares
    initial_guesses: tuple[HypothesisTerm, ...]
    """Where its fit may begin; the best first, as far as first order tells."""


def try_all(problem: Problem, effects: Mapping[str, type[Any]]) -> ScreeningDirections:
    """Simulate each effect at each of its initial guesses."""
    captures = [e.capture for e in problem.evidence if isinstance(e, (PictureEvidence, BoardEvidence))]
    found: dict[str, list[ScreeningDirection]] = {}
    for name, cls in effects.items():
        for term in initial_guesses_for(name, cls, captures):
            z = problem.residual((term,))
            if z is not None and not np.array_equal(z, problem.null):
                found.setdefault(name, []).append(ScreeningDirection(term, z - problem.null))
    return found


def in_units(directions: ScreeningDirections, factor: NDArray[np.float64]) -> ScreeningDirections:
    """The directions with residuals multiplied by (K,) `factor`."""
    return {
        name: [ScreeningDirection(direction.term, direction.change * factor) for direction in of_effect]
        for name, of_effect in directions.items()
    }


def screening_score(directions: Sequence[ScreeningDirection], base: NDArray[np.float64]) -> ScreeningScore:
    """Gain of an effect on top of (K,) residuals.

    Each direction is scaled by itself; directions of one parameter each are also combined, and a fit
    that begins at one of them has them all free.
    """
    cost = float(np.sum(robust(base) ** 2))
    single = _of_one_parameter(directions)
    found: list[tuple[float, HypothesisTerm]] = []
    for shares in (SHARES, (1.0,)):  # scaled, and as it was simulated: what is cut off at 0 does not scale
        scaled = [
            (cost - float(np.sum(robust(base + share * direction.change) ** 2)), direction, share)
            for direction in directions
            for share in (shares if direction.term.free else (1.0,))  # discrete effects are there or not
        ]
        gain, direction, share = max(scaled, key=lambda each: each[0])
        found.append((gain, _with_all_free(_scaled(direction.term, share), single)))
    if single and (combined := _combined(single, base)) is not None:
        found.append(combined)
    found.sort(key=lambda each: -each[0])
    guesses = {repr(term.values): term for _, term in found}
    return ScreeningScore(found[0][0], tuple(guesses.values()))


def all_initial_guesses(directions: Sequence[ScreeningDirection]) -> list[HypothesisTerm]:
    single = _of_one_parameter(directions)
    return [_with_all_free(direction.term, single) for direction in directions]


def _of_one_parameter(directions: Sequence[ScreeningDirection]) -> Mapping[str, ScreeningDirection]:
    """Directions with one free parameter, by its name; none where there are not several, or they are few."""
    single = {
        next(iter(direction.term.free)): direction
        for direction in directions
        if len(direction.term.free) == 1
    }
    return {} if len(single) < 2 or len(single) < len(directions) / 2 else single


def _with_all_free(term: HypothesisTerm, single: Mapping[str, ScreeningDirection]) -> HypothesisTerm:
    if len(term.free) != 1 or not single:
        return term
    values = {name: _scaled(direction.term, 0.0).values[name] for name, direction in single.items()}
    steps = {name: direction.term.free[name] for name, direction in single.items()}
    wider = replace(term, values={**values, **term.values}, free={**steps, **term.free})
    return wider if wider.placed() is not None else term


def _combined(
    single: Mapping[str, ScreeningDirection], base: NDArray[np.float64]
) -> tuple[float, HypothesisTerm] | None:
    """Directions of one free parameter each, combined by least squares: what they gain, and the term."""
    directions = list(single.values())
    shares = combined_shares(directions, base)
    term = term_at(directions, shares)
    return None if term is None else (combined_gain(directions, shares, base), term)


def apart(directions: Sequence[ScreeningDirection], base: NDArray[np.float64]) -> list[ScreeningDirection]:
    """Those directions of an effect that may be added up: one for each parameter, else the best of all."""
    forms = forms_of(directions)
    if len(forms) == 1:
        return forms[0]
    return max(forms, key=lambda form: combined_gain(form, combined_shares(form, base), base))


def forms_of(directions: Sequence[ScreeningDirection]) -> list[list[ScreeningDirection]]:
    """Directions of an effect that may be added up: all where each has a parameter of its own, else each."""
    single = list(_of_one_parameter(directions).values())
    return [single] if single else [[direction] for direction in directions]


def columns_on(form: Sequence[ScreeningDirection], base: NDArray[np.float64]) -> NDArray[np.float64]:
    """(K, D) what directions change in the robust residuals beside (K,) residuals."""
    return np.stack([robust(base + one.change) - robust(base) for one in form], axis=1)


def combined_shares(
    directions: Sequence[ScreeningDirection], base: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(D,) multiples of directions that together leave least of (K,) residuals, to first order."""
    changes = np.stack([direction.change for direction in directions], axis=1)
    weights = robust_derivative(base)
    normal = (changes * weights[:, None]).T @ changes
    ridge = RIDGE * float(np.trace(normal)) / len(normal)
    shares = -np.linalg.solve(normal + ridge * np.eye(len(normal)), changes.T @ (weights * base))
    return np.clip(shares, -4, 4)


def combined_gain(
    directions: Sequence[ScreeningDirection], shares: NDArray[np.float64], base: NDArray[np.float64]
) -> float:
    """Fall of the sum of robust squares with (D,) multiples of directions added to (K,) residuals."""
    changes = np.stack([direction.change for direction in directions], axis=1)
    return float(np.sum(robust(base) ** 2) - np.sum(robust(base + changes @ shares) ** 2))


def term_at(directions: Sequence[ScreeningDirection], shares: NDArray[np.float64]) -> HypothesisTerm | None:
    """The effect with (D,) multiples of its directions, all their parameters free; None where it refuses."""
    if len(directions) == 1:
        return _scaled(directions[0].term, float(shares[0]))
    values: dict[str, Any] = {}
    free: dict[str, float] = {}
    for direction, share in zip(directions, shares, strict=True):
        (key,) = direction.term.free
        values |= {**direction.term.values, key: _scaled(direction.term, float(share)).values[key]}
        free[key] = direction.term.free[key]
    term = replace(directions[0].term, values=values, free=free)
    return term if term.placed() is not None else None


def _scaled(term: HypothesisTerm, scale: float) -> HypothesisTerm:
    """A term with its free parameters moved to `scale` times their distance from neutral."""
    if not term.free or scale == 1.0:
        return term
    moved = []
    for key, value in zip(term.free, theta_of((term,)), strict=True):
        at = neutral_value(term.cls, key)
        moved.append(value if at is None else at + scale * (value - at))
    changed = term.with_free(moved)
    return changed if changed.placed() is not None else term
