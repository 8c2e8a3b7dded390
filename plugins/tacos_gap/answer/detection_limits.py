"""Detection limits: the least value of each effect that these captures could not have hidden.

Near neutral the residuals change by s^p times what they change at an initial guess, s of the way there. An
effect is named once a statistic of a capture is significant, for else nothing is looked for, changes by what
matters, and half of all squares exceed the complexity penalty. At the limit half of such captures show it.
Noise adds in squares (p = 2), most else in proportion (p = 1); a second simulation nearer to neutral tells.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework.formation import PlacedEffect
from tacos_gap.answer.findings import short
from tacos_gap.attribution import COMPLEXITY_PENALTY, LEAST_CHANGE
from tacos_gap.evidence import Evidence, PictureEvidence
from tacos_gap.evidence.boards import BoardEvidence
from tacos_gap.evidence.elsewhere import of_each
from tacos_gap.hypotheses.parameters import HypothesisTerm, initial_guesses_of
from tacos_gap.inference.problem import Problem, placed
from tacos_gap.inference.significance import least_significant
from tacos_gap.inference.unknown import SIGNIFICANT, SLACK, block_index

EXPONENTS = (0.5, 3.0)
"""Powers that are believed."""

_NEARER = 0.3  # share of the way to a guess at which the power is taken


def detection_limits(
    problem: Problem, effects: Mapping[str, type[Any]], left: NDArray[np.float64]
) -> dict[str, dict[str, float]]:
    """The least value of the main parameter of each effect that would have shown.

    One capture of each kind, the brightest, stands for all of its kind, so that the price is bounded: two
    simulations of each for every effect. Views of boards are adjusted together, and all count.

    - `left`: (K,) residuals beside the explanation: what noise there is for an effect to hide in [noise
      floor].

    Returns: by effect, its main parameter (the first that its initial guesses move) and the value, in the
    unit of that parameter; effects that no capture shows, and those without such a parameter, are left out.
    """
    terms = [term for name, cls in effects.items() if (term := _beginning(name, cls)) is not None]
    nearer = [term.with_free([_on_the_way(term, _NEARER)]) for term in terms]
    sizes = _Probe.of(problem, left).sizes([*terms, *nearer])
    limits = map(_limit, terms, sizes[: len(terms)], sizes[len(terms) :])
    return {
        term.name: {_main(term): limit}
        for term, limit in zip(terms, limits, strict=True)
        if limit is not None
    }


def _beginning(name: str, cls: type[Any]) -> HypothesisTerm | None:
    for term in initial_guesses_of(name, cls):
        for key in term.free:
            if isinstance(cls.neutral.get(key), float) and term.values[key] != cls.neutral[key]:
                return HypothesisTerm(name, cls, term.values, {key: term.free[key]})
    return None


def _main(term: HypothesisTerm) -> str:
    return next(iter(term.free))


def _on_the_way(term: HypothesisTerm, share: float) -> float:
    """Value of the main parameter a share of the way from neutral to the guess."""
    neutral = float(term.cls.neutral[_main(term)])
    return neutral + share * (float(term.values[_main(term)]) - neutral)


def _limit(term: HypothesisTerm, there: float, nearer: float) -> float | None:
    """The limit from the sizes of an effect at its guess, and nearer to neutral."""
    if not there:
        return None
    power = np.log(there / nearer) / np.log(1 / _NEARER) if nearer else 1.0
    share = there ** (-1 / float(np.clip(power, *EXPONENTS)))
    found = term.with_free([_on_the_way(term, share)])
    return short(found.theta[0]) if found.placed() is not None else None


@dataclass(frozen=True, eq=False)
class _Probe:
    """Simulations of a part of the evidence."""

    parts: Sequence[_Part]  # one capture of each kind, and all views of boards
    weight: float  # how many independent numbers one is worth

    @classmethod
    def of(cls, problem: Problem, left: NDArray[np.float64]) -> _Probe:
        blocks = block_index(problem)
        needed = least_significant(left, problem.null_replicates, blocks, SIGNIFICANT, SLACK)
        kinds: dict[str, list[_Part]] = {}
        for evidence, slot in zip(problem.evidence, problem.slots, strict=True):
            if len(evidence.labels):
                here = slice(slot.start, slot.stop)
                own = blocks[here]
                part = _Part(
                    evidence,
                    1,
                    evidence.residual(()),
                    problem.scale[here],
                    own - own.min(),
                    needed[np.unique(own)],
                )
                kinds.setdefault(evidence.labels[0].kind, []).append(part)
        chosen: list[_Part] = []
        for members in kinds.values():
            if isinstance(members[0].evidence, BoardEvidence):
                chosen += members
            else:
                brightest = max(members, key=lambda part: _brightness(part.evidence))
                chosen.append(replace(brightest, count=len(members)))
        return cls(chosen, problem.weight)

    def sizes(self, terms: Sequence[HypothesisTerm]) -> list[float]:
        """Sizes of effects: 1 where one would just be named, 0 for one that shows nowhere."""
        effects = [placed((term,)) for term in terms]
        of_parts = of_each(partial(_residuals, effects), [part.evidence for part in self.parts])
        return [self._size([of_part[k] for of_part in of_parts]) for k in range(len(terms))]

    def _size(self, residuals: Sequence[NDArray[np.float64]]) -> float:
        squares, largest, significant = 0.0, 0.0, 0.0
        for part, z in zip(self.parts, residuals, strict=True):
            change = ((z - part.null) / part.scale) ** 2
            by_block = np.bincount(part.blocks, change)
            squares += part.count * float(change.sum())
            largest = max(largest, float((by_block / np.bincount(part.blocks)).max()))
            significant = max(significant, float((by_block / part.needed).max()))
        gain = 0.5 * self.weight * squares
        return float(np.sqrt(min(gain / COMPLEXITY_PENALTY, largest / LEAST_CHANGE, significant)))


@dataclass(frozen=True, eq=False)
class _Part:
    """One capture, or view."""

    evidence: Evidence
    count: int  # how many like it there are
    null: NDArray[np.float64]  # (K,) its residuals without effects [noise floor]
    scale: NDArray[np.float64]  # (K,) the noise floor of the explanation over the simulator's own
    blocks: NDArray[np.int64]  # (K,) the block of each number
    needed: NDArray[np.float64]  # (M,) what the squares of each block must grow by to be significant


def _residuals(effects: Sequence[list[PlacedEffect]], evidence: Evidence) -> list[NDArray[np.float64]]:
    """(K,) residuals with each of some sets of effects; an effect that refuses its values is none."""
    return [evidence.residual(each) for each in effects]


def _brightness(evidence: Evidence) -> float:
    """Expected signal times exposure time: of darks the longest, of others the brightest."""
    if not isinstance(evidence, PictureEvidence):
        return 0.0
    capture = evidence.capture
    assert capture.expected_dn is not None
    return float(capture.expected_dn.mean()) * (capture.context.exposure_s or 1.0)
