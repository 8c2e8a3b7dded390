"""Negative control: the closure by selection alone where nothing is to be found."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_gap.attribution.result import Attribution
from tacos_gap.inference.closure import closure
from tacos_gap.inference.fit import held_parts_for, move_of_fold
from tacos_gap.inference.problem import robust
from tacos_gap.inference.screening import columns_on, forms_of
from tacos_gap.inference.unknown import block_index


@dataclass(frozen=True)
class NegativeControl:
    """Closure by selection of numbers that mean nothing."""

    effects: int  # how many are chosen, as many as the explanation has
    among: int  # from how many
    closure: float  # the middle one of many controls; near 0 where what is held out is to be trusted
    interval: tuple[float, float]  # that holds 90 % of them
    p_value: float  # share of controls that close as much as the explanation


def negative_control(
    attribution: Attribution, closed: float, rng: np.random.Generator, draws: int = 64
) -> NegativeControl | None:
    """Choose among all effects, to first order, on the captures' own residuals without their meaning.

    The numbers of each block are exchanged at random and turned about: there is as much to explain in
    the same places, and nothing explains it. As many effects as the explanation has are chosen and fitted by
    one fold, one after another, and held against the other. None where nothing was explained.

    `closed`: what the explanation closes, held out alike.
    """
    problem, count = attribution.problem, len(attribution.best.hypothesis)
    if not count:
        return None
    z = _without_meaning(problem.null, block_index(problem), rng, draws)
    forms = [form for of_effect in attribution.directions.values() for form in forms_of(of_effect)]
    columns = [columns_on(form, problem.null) for form in forms]
    changes = [np.stack([direction.change for direction in form], axis=1) for form in forms]
    held_parts = held_parts_for(problem, attribution.best.hypothesis)
    predicted = z.copy()
    for held in held_parts:
        left = z
        for _ in range(count):
            left = _with_one_more(left, columns, changes, ~held, problem.weight)
        predicted[held] = left[held]
    alone = ~(held_parts[0] | held_parts[1])
    predicted[alone] = left[alone]
    before = problem.gap(problem.null)
    after = np.sqrt(np.mean(predicted**2, axis=0)) / problem.noise_floor_rms
    found = [closure(before, each) for each in after.tolist()]
    low, middle, high = np.percentile(found, (5, 50, 95)).tolist()
    as_much = sum(each >= closed for each in found)
    among = len(attribution.directions)
    return NegativeControl(count, among, middle, (low, high), (1 + as_much) / (1 + draws))


def _without_meaning(
    z: NDArray[np.float64], blocks: NDArray[np.int64], rng: np.random.Generator, draws: int
) -> NDArray[np.float64]:
    """(K, D) residuals exchanged within their blocks, with random signs."""
    found = np.empty((len(z), draws))
    for k in range(int(blocks.max()) + 1):
        block = np.flatnonzero(blocks == k)
        for draw in range(draws):
            found[block, draw] = z[rng.permutation(block)]
    return np.asarray(found * rng.choice((-1.0, 1.0), found.shape))


def _with_one_more(
    left: NDArray[np.float64],
    columns: Sequence[NDArray[np.float64]],
    changes: Sequence[NDArray[np.float64]],
    seen: NDArray[np.bool_],
    weight: float,
) -> NDArray[np.float64]:
    """(K, D) what is left with the effect that gains most in the numbers seen, each draw its own.

    `columns`, `changes`: (K, P) what each effect changes in the robust residuals, and in the residuals.
    """
    best, least = left, np.full(left.shape[1], np.inf)
    straight = robust(left)
    for own, change in zip(columns, changes, strict=True):
        changed = left + change @ move_of_fold(own[seen], straight[seen])
        cost = 0.5 * weight * np.sum(robust(changed[seen]) ** 2, axis=0) + own.shape[1]
        better = cost < least
        best, least = np.where(better, changed, best), np.where(better, cost, least)
    return best
