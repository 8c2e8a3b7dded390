"""Settings that no slope leads to, as the quality of a codec or a way of rounding, searched one by one.

What an effect declares says what there is to search: the whole numbers that its initial guesses name,
within the bounds of its settings, and the settings that take one of several words.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any, Literal, get_args, get_origin

import numpy as np
from numpy.typing import NDArray

from tacos_framework import EffectBase, optional
from tacos_gap.hypotheses.by_capture import is_of_one_capture
from tacos_gap.hypotheses.parameters import HypothesisTerm
from tacos_gap.inference.problem import Hypothesis, Problem, robust

ROUNDS = 3
"""Passes over all settings of an effect at most: they seldom hang on one another."""


def searched(
    problem: Problem,
    hypothesis: Hypothesis,
    part: NDArray[np.bool_] | None = None,
    farthest: int | None = None,
) -> Hypothesis:
    """A hypothesis with the discrete settings of its last effect where they leave least.

    - `hypothesis`: one that its effects allow; the parameters that are fitted stay as they are.
    - `part`: (K,) the numbers that count; all by default.
    - `farthest`: the longest stride over whole numbers; past the next initial guess by default.
    """
    *rest, term = hypothesis
    whole, words = whole_numbers(term), words_of(term)
    if term.is_stated or not (whole or words):
        return hypothesis
    known: dict[str, float] = {}

    def cost(candidate: HypothesisTerm) -> float:
        key = repr(sorted(candidate.values.items()))
        if key not in known:
            z = None if candidate.placed() is None else problem.residual((*rest, candidate))
            known[key] = np.inf if z is None else float(np.sum(robust(z if part is None else z[part]) ** 2))
        return known[key]

    for _ in range(ROUNDS):
        before = term
        for name, choices in words.items():
            term = min([term, *(_with(term, name, word) for word in choices)], key=cost)
        for name, past_the_next in whole.items():
            stride = min(past_the_next, farthest or past_the_next)
            while stride >= 1:  # the nearest guess is less than a stride away
                term = min(
                    [term, *(_with(term, name, term.values[name] + s) for s in (-stride, stride))], key=cost
                )
                stride //= 2
        if term == before:
            break
    return (*rest, term)


def whole_numbers(term: HypothesisTerm) -> dict[str, int]:
    """Settings of a term that are whole numbers, each with a stride that leads past the next guess."""
    found = {}
    for name, value in term.values.items():
        if type(value) is not int or is_of_one_capture(name):  # a file says its own quality
            continue
        named = {value, *(v for guess in _guesses(term) if type(v := guess.get(name)) is int)}
        gaps = [abs(other - value) for other in named if other != value]
        found[name] = 1 << max(min(gaps, default=1) - 1, 1).bit_length() - 1
    return found


def words_of(term: HypothesisTerm) -> dict[str, tuple[Any, ...]]:
    """Settings of a term that take one of several words, each with all of them."""
    return {
        name: get_args(field.annotation)
        for name, field in term.cls.Config.model_fields.items()
        if get_origin(field.annotation) is Literal
    }


def with_other_words(term: HypothesisTerm) -> Iterator[HypothesisTerm]:
    """A term with each other word that one of its settings takes; none where files state it."""
    now = term.placed()
    if term.is_stated or now is None:
        return
    for name, choices in words_of(term).items():
        for word in choices:
            other = _with(term, name, word)
            if word != getattr(now.config, name) and other.placed() is not None:
                yield other


def _guesses(term: HypothesisTerm) -> Iterator[Any]:
    yield from optional(term.cls, EffectBase, "initial_guesses") or ()


def _with(term: HypothesisTerm, name: str, value: Any) -> HypothesisTerm:
    return replace(term, values={**term.values, name: value})
