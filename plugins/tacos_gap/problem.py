"""All evidence of a folder together, and how a hypothesis fares on it."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from threading import Lock

import numpy as np
from numpy.typing import NDArray

from tacos_framework.formation import PlacedEffect
from tacos_gap.evidence import Evidence, Judged, Label
from tacos_gap.parameters import Term

BEND = 10.0
"""Beyond so many units of the floor residuals count less and less: asinh in place of the straight line."""

Hypothesis = tuple[Term, ...]


def bent(z: NDArray[np.float64]) -> NDArray[np.float64]:
    """Residuals that a few wild ones cannot rule; nearly the same below `BEND`."""
    return np.asarray(BEND * np.arcsinh(z / BEND))


def slope(z: NDArray[np.float64]) -> NDArray[np.float64]:
    """How much bent residuals move per unit of these: the derivative of `bent`."""
    return np.asarray(1 / np.sqrt(1 + (z / BEND) ** 2))


def _joined(floors: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
    """Floors of captures side by side, as many replicates as the least has."""
    count = min((len(floor) for floor in floors), default=0)
    return np.concatenate([floor[:count] for floor in floors], axis=1) if floors else np.zeros((2, 0))


def _key(hypothesis: Hypothesis) -> str:
    """What tells hypotheses apart."""
    return repr([(term.name, sorted(term.values.items(), key=str)) for term in hypothesis])


def placed(hypothesis: Hypothesis) -> list[PlacedEffect]:
    """The effects of a hypothesis as a recipe places them, without those that refuse their values."""
    return [effect for term in hypothesis if (effect := term.placed()) is not None]


@dataclass(frozen=True)
class Slot:
    """Where the numbers of a capture stand in the whole."""

    start: int
    stop: int


class Problem:
    """Evidence of all captures as one vector of residuals.

    Parameters
    ----------
    evidence
        One per capture, or view.
    """

    def __init__(self, evidence: Sequence[Evidence]):
        self.evidence = list(evidence)
        sizes = [len(e.labels) for e in self.evidence]
        ends = np.cumsum([0, *sizes])
        self.slots = [Slot(int(a), int(b)) for a, b in pairwise(ends)]
        self.labels: list[Label] = [label for e in self.evidence for label in e.labels]
        self.null = np.concatenate([e.residual(()) for e in self.evidence]) if self.evidence else np.zeros(0)
        self.floor = _joined([e.floor for e in self.evidence])
        self.scale = np.ones(len(self.labels))
        self.draws = 1
        self.evaluations = 0
        self._kept: dict[str, NDArray[np.float64]] = {}
        self._judged: dict[str, Judged] = {}
        self._lock = Lock()

    def residual(self, hypothesis: Hypothesis) -> NDArray[np.float64] | None:
        """(K,) residuals in units of the floor; None where an effect refuses its parameters."""
        key = f"{self.draws} {_key(hypothesis)}"
        effects = placed(hypothesis)
        if len(effects) < len(hypothesis):
            return None
        with self._lock:
            if key in self._kept:
                return self._kept[key] / self.scale
            self.evaluations += 1
        z = np.empty(len(self.labels))
        for evidence, slot in zip(self.evidence, self.slots, strict=True):
            z[slot.start : slot.stop] = evidence.residual(effects, self.draws)
        z = np.nan_to_num(z, nan=1e3, posinf=1e3, neginf=-1e3)
        with self._lock:
            self._kept[key] = z
        return z / self.scale

    def judged(self, hypothesis: Hypothesis) -> Judged:
        """Residuals and floor when the hypothesis is part of the simulator; see `Evidence.judged`."""
        key = _key(hypothesis)
        if key not in self._judged:
            self._judged[key] = self._judge(hypothesis)
        return self._judged[key]

    def _judge(self, hypothesis: Hypothesis) -> Judged:
        effects = placed(hypothesis)
        parts = [evidence.judged(effects) for evidence in self.evidence]
        return Judged(
            np.concatenate([part.z for part in parts]),
            _joined([part.floor for part in parts]),
            np.concatenate([part.scale for part in parts]),
        )

    def reweighted(self, scale: NDArray[np.float64]) -> Problem:
        """The same evidence in units of a larger floor; what was simulated is kept."""
        other = copy(self)
        for name in ("weight", "floor_size", "floor_gaps"):
            other.__dict__.pop(name, None)
        other.scale = scale
        other.null = self.null * self.scale / scale
        other.floor = self.floor * self.scale / scale
        return other

    def averaging(self, draws: int) -> Problem:
        """The same evidence, each hypothesis by the mean of several simulations."""
        other = copy(self)
        other.draws = draws
        return other

    # what counts how much ---------------------------------------------------------------------------------

    @cached_property
    def weight(self) -> float:
        """How many independent numbers one of these is worth, as they vary together (Satterthwaite)."""
        squares = (bent(self.floor) ** 2).sum(axis=1)
        spread = float(squares.var(ddof=1))
        return float(np.clip(2 * squares.mean() / max(spread, 1e-9), 0.02, 1.0))

    @cached_property
    def floor_size(self) -> float:
        """Root mean square of the floor's own residuals."""
        return float(np.sqrt(np.mean(bent(self.floor) ** 2)))

    def gap(self, z: NDArray[np.float64], part: NDArray[np.bool_] | None = None) -> float:
        """Root mean square residual, in units of that of the floor [floor]."""
        chosen = z if part is None else z[part]
        return float(np.sqrt(np.mean(bent(chosen) ** 2)) / self.floor_size) if chosen.size else 0.0

    @cached_property
    def floor_gaps(self) -> NDArray[np.float64]:
        """(B,) gaps of the simulator against itself [floor]."""
        return np.array([self.gap(z) for z in self.floor])

    @cached_property
    def fold(self) -> NDArray[np.bool_]:
        """(K,) which of two folds each number is in.

        Captures of a kind alternate, so that what is fitted on some levels, views or scenes is judged on
        others; a kind with a single capture is split by place, level and frequency.
        """
        fold = np.zeros(len(self.labels), bool)
        order: dict[str, list[int]] = {}
        for i, evidence in enumerate(self.evidence):
            if evidence.labels:
                order.setdefault(evidence.labels[0].kind, []).append(i)
        for members in order.values():
            for place, i in enumerate(members):
                slot = self.slots[i]
                if len(members) > 1:
                    fold[slot.start : slot.stop] = place % 2 == 1
                else:
                    fold[slot.start : slot.stop] = np.arange(slot.stop - slot.start) % 2 == 1
        return fold
