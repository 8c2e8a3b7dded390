"""What would have shown: the least value of each effect that these captures could not have hidden.

Near neutral the residuals change by s^p times what they change at an initial guess, s of the way there; an
effect is named once half their squares exceed the complexity penalty and a statistic changes by what matters.
Noise adds in squares (p = 2), most else in proportion (p = 1); a second simulation nearer to neutral tells.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_gap.attribution import COMPLEXITY_PENALTY, LEAST_CHANGE
from tacos_gap.evidence import Evidence, ImageEvidence
from tacos_gap.findings import short
from tacos_gap.parameters import HypothesisTerm, initial_guesses_of
from tacos_gap.problem import Problem, placed

EXPONENTS = (0.5, 3.0)
"""Powers that are believed."""

_NEARER = 0.3  # share of the way to a guess at which the power is taken

Map = Callable[[Callable[[HypothesisTerm], Any], Iterable[HypothesisTerm]], Iterable[Any]]


def detection_limits(
    problem: Problem, effects: Mapping[str, type[Any]], each: Map = map
) -> dict[str, dict[str, float]]:
    """The least value of the main parameter of each effect that would have shown.

    One capture of each kind, the brightest, stands for all of its kind, so that the price is bounded: two
    simulations of each for every effect.

    Parameters
    ----------
    problem
        The evidence.
    effects
        Classes of the effects by name.
    each
        A map that may work in parallel.

    Returns
    -------
    dict
        By effect, its main parameter (the first that its initial guesses move) and the value, in the unit of
        that parameter; effects that no capture shows, and those without such a parameter, are left out.
    """
    terms = [term for name, cls in effects.items() if (term := _beginning(name, cls)) is not None]
    probe = _Probe.of(problem)
    limits = each(lambda term: _limit(probe, term), terms)
    return {
        term.name: {_main(term): limit}
        for term, limit in zip(terms, limits, strict=True)
        if limit is not None
    }


def _beginning(name: str, cls: type[Any]) -> HypothesisTerm | None:
    """The first initial guess that moves a number away from neutral."""
    for term in initial_guesses_of(name, cls):
        for key in term.free:
            if isinstance(cls.neutral.get(key), float) and term.values[key] != cls.neutral[key]:
                return HypothesisTerm(name, cls, term.values, {key: term.free[key]})
    return None


def _main(term: HypothesisTerm) -> str:
    return next(iter(term.free))


def _limit(probe: _Probe, term: HypothesisTerm) -> float | None:
    neutral = float(term.cls.neutral[_main(term)])
    distance = float(term.values[_main(term)]) - neutral
    there = probe.size(term)
    nearer = probe.size(term.with_free([neutral + _NEARER * distance]))
    if not there:
        return None
    power = np.log(there / nearer) / np.log(1 / _NEARER) if nearer else 1.0
    share = there ** (-1 / float(np.clip(power, *EXPONENTS)))
    found = term.with_free([neutral + share * distance])
    return short(found.theta[0]) if found.placed() is not None else None


@dataclass(frozen=True, eq=False)
class _Probe:
    """One capture of each kind, with the number of captures it stands for."""

    evidence: Sequence[Evidence]
    counts: Sequence[int]
    null: NDArray[np.float64]
    weight: float

    @classmethod
    def of(cls, problem: Problem) -> _Probe:
        """The brightest of each kind."""
        kinds: dict[str, list[Evidence]] = {}
        for evidence in problem.evidence:
            if len(evidence.labels):
                kinds.setdefault(evidence.labels[0].kind, []).append(evidence)
        chosen = [max(members, key=_brightness) for members in kinds.values()]
        null = np.concatenate([each.residual(()) for each in chosen]) if chosen else np.zeros(0)
        return cls(chosen, [len(members) for members in kinds.values()], null, problem.weight)

    def size(self, term: HypothesisTerm) -> float:
        """How much an effect changes, 1 where it would just be named; 0 for one that shows nowhere."""
        effects = placed((term,))
        if not effects:
            return 0.0
        squares, largest, start = 0.0, 0.0, 0
        for evidence, count in zip(self.evidence, self.counts, strict=True):
            z = evidence.residual(effects)
            change = (z - self.null[start : start + len(z)]) ** 2
            start += len(z)
            squares += count * float(change.sum())
            blocks = _statistic_of(evidence)
            largest = max(largest, float((np.bincount(blocks, change) / np.bincount(blocks)).max()))
        gain = 0.5 * self.weight * squares
        return float(np.sqrt(min(gain / COMPLEXITY_PENALTY, largest / LEAST_CHANGE)))


def _statistic_of(evidence: Evidence) -> NDArray[np.int64]:
    """(K,) the statistic of each number of one capture."""
    names = list(dict.fromkeys(label.statistic for label in evidence.labels))
    return np.array([names.index(label.statistic) for label in evidence.labels], np.int64)


def _brightness(evidence: Evidence) -> float:
    """Expected signal times exposure time: of darks the longest, of others the brightest."""
    if not isinstance(evidence, ImageEvidence):
        return 0.0
    capture = evidence.capture
    assert capture.expected_dn is not None
    return float(capture.expected_dn.mean()) * (capture.context.exposure_s or 1.0)
