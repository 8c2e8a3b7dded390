"""All evidence of a folder together, and how a hypothesis fares on it."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from tacos_framework.formation import PlacedEffect
from tacos_gap.evidence import Evidence, Label, PictureEvidence, ReplicateResiduals
from tacos_gap.evidence.elsewhere import of_each
from tacos_gap.hypotheses.parameters import HypothesisTerm
from tacos_gap.nuisances import shares_of_priors

ROBUST_SCALE = 10.0
"""Residual from which on the robust one grows by the logarithm [noise floor]."""

PLACES_APART = 4
"""Parts that the places of a statistic are cut into: every second is held out, so that neighbours, which vary
together, mostly are in one fold."""

LEAST_FLOOR = 0.2
"""Least noise floor, in units of which a negligible difference is 1: darks without a pedestal have none."""

CLOSE_SHARES = 2.0
"""Factor by which narrowed priors of pose may change without anything being simulated anew."""

Hypothesis = tuple[HypothesisTerm, ...]


def robust(z: NDArray[np.float64]) -> NDArray[np.float64]:
    """Robust residuals, arsinh-like, which outliers cannot rule; nearly the same below `ROBUST_SCALE`.

    Searches go by them. What is found is judged on plain squares.
    """
    return np.asarray(ROBUST_SCALE * np.arcsinh(z / ROBUST_SCALE))


def robust_derivative(z: NDArray[np.float64]) -> NDArray[np.float64]:
    """Derivative of `robust`."""
    return np.asarray(1 / np.sqrt(1 + (z / ROBUST_SCALE) ** 2))


def floor_rms(replicates: NDArray[np.float64]) -> float:
    """Root mean square of a noise floor's own (B, K) residuals, at least `LEAST_FLOOR` [noise floor]."""
    return max(float(np.sqrt(np.mean(replicates**2))), LEAST_FLOOR) if replicates.size else 1.0


def _side_by_side(replicates: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
    """Replicates of captures side by side, as many replicates as the least has."""
    count = min((len(each) for each in replicates), default=0)
    return np.concatenate([each[:count] for each in replicates], axis=1) if replicates else np.zeros((2, 0))


def _joined(parts: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
    return np.concatenate([*parts, np.zeros(0)])


def _key(hypothesis: Hypothesis) -> str:
    return repr([(term.name, sorted(term.values.items(), key=str)) for term in hypothesis])


def _place(label: Label) -> str:
    return repr(sorted((name, value) for name, value in label.at.items() if name != "channel"))


def without(hypothesis: Hypothesis, name: str) -> Hypothesis:
    return tuple(term for term in hypothesis if term.name != name)


def placed(hypothesis: Hypothesis, capture: str | None = None) -> list[PlacedEffect]:
    """The effects of a hypothesis as a recipe places them, without those that refuse their values."""
    return [effect for term in hypothesis if (effect := term.placed(capture)) is not None]


def is_allowed(hypothesis: Hypothesis) -> bool:
    """True if no effect refuses its values."""
    return all(term.placed() is not None for term in hypothesis)


def placed_in(hypothesis: Hypothesis, evidence: Evidence) -> list[PlacedEffect]:
    """The effects of a hypothesis for the capture that evidence is of; boards are adjusted all together."""
    return placed(hypothesis, evidence.capture.id if isinstance(evidence, PictureEvidence) else None)


def _residual(hypothesis: Hypothesis, draws: int, evidence: Evidence) -> NDArray[np.float64]:
    return evidence.residual(placed_in(hypothesis, evidence), draws)


def _replicate_residuals(hypothesis: Hypothesis, evidence: Evidence) -> ReplicateResiduals:
    return evidence.replicate_residuals(placed_in(hypothesis, evidence))


def _renuisanced(hypothesis: Hypothesis, evidence: Evidence) -> Evidence:
    if not isinstance(evidence, PictureEvidence):
        return evidence
    return evidence.renuisanced(placed_in(hypothesis, evidence))


def _pose(hypothesis: Hypothesis, evidence: Evidence) -> dict[str, float] | None:
    return evidence.pose(placed_in(hypothesis, evidence)) if isinstance(evidence, PictureEvidence) else None


def _agreeing(shares: Mapping[str, float], evidence: Evidence) -> Evidence:
    return evidence.agreeing(shares) if isinstance(evidence, PictureEvidence) else evidence


def _null_replicates(evidence: Evidence) -> NDArray[np.float64]:
    return evidence.null_replicates


def _shares_of_priors(evidence: Sequence[Evidence], hypothesis: Hypothesis) -> dict[str, float]:
    poses, groups = [], []
    for pose, each in zip(of_each(partial(_pose, hypothesis), evidence), evidence, strict=True):
        if pose is not None:
            assert isinstance(each, PictureEvidence)
            poses.append(pose)
            groups.append(each.capture.group or each.capture.id)
    return shares_of_priors(poses, groups)


def _are_close(shares: dict[str, float], others: dict[str, float]) -> bool:
    """True if the same priors are narrowed, by factors within `CLOSE_SHARES`."""
    return shares.keys() == others.keys() and all(
        1 / CLOSE_SHARES < share / others[name] < CLOSE_SHARES for name, share in shares.items()
    )


@dataclass
class Tally:
    """Number of simulations of all captures, of a problem and of all that were made of it."""

    simulations: int = 0


@dataclass(frozen=True)
class Slot:
    """Place of a capture's numbers in the whole."""

    start: int
    stop: int


class Problem:
    """Evidence of all captures as one vector of residuals."""

    def __init__(self, evidence: Sequence[Evidence]):
        self.evidence = list(evidence)
        sizes = [len(e.labels) for e in self.evidence]
        ends = np.cumsum([0, *sizes])
        self.slots = [Slot(int(a), int(b)) for a, b in pairwise(ends)]
        self.labels: list[Label] = [label for e in self.evidence for label in e.labels]
        self.null = _joined(of_each(partial(_residual, (), 1), self.evidence))
        self.null_replicates = _side_by_side(of_each(_null_replicates, self.evidence))
        self.scale = np.ones(len(self.labels))
        self.spread: dict[str, NDArray[np.float64]] = {}
        self._spread_in: frozenset[str] = frozenset()
        self.draws = 1
        self._tally = Tally()
        self._stated = self.evidence
        self._shares: dict[str, float] = {}
        self._kept: dict[str, NDArray[np.float64]] = {}
        self._replicate_residuals: dict[str, ReplicateResiduals] = {}

    @property
    def simulations(self) -> int:
        """Those of all captures that residuals took so far, in other units and of averages too."""
        return self._tally.simulations

    def residual(self, hypothesis: Hypothesis) -> NDArray[np.float64] | None:
        """(K,) residuals in units of the noise floor; None where an effect refuses its parameters."""
        key = f"{self.draws} {_key(hypothesis)}"
        if not is_allowed(hypothesis):
            return None
        if key not in self._kept:
            self._tally.simulations += self.draws
            z = _joined(of_each(partial(_residual, hypothesis, self.draws), self.evidence))
            self._kept[key] = np.nan_to_num(z, nan=1e3, posinf=1e3, neginf=-1e3)
        return self._kept[key] / self.scale

    def replicate_residuals(self, hypothesis: Hypothesis) -> ReplicateResiduals:
        key = _key(hypothesis)
        if key not in self._replicate_residuals:
            self._replicate_residuals[key] = self._simulate_replicates(hypothesis)
        return self._replicate_residuals[key]

    def _simulate_replicates(self, hypothesis: Hypothesis) -> ReplicateResiduals:
        parts = of_each(partial(_replicate_residuals, hypothesis), self.evidence)
        return ReplicateResiduals(
            np.concatenate([part.z for part in parts]),
            _side_by_side([part.replicates for part in parts]),
            np.concatenate([part.scale for part in parts]),
        )

    def reweighted(self, scale: NDArray[np.float64], names: Collection[str] = ()) -> Problem:
        """The same evidence in units of a larger noise floor; what was simulated is kept.

        `names`: the effects whose noise floor it is.
        """
        other = copy(self)
        for name in ("weight", "noise_floor_rms", "null_gaps"):
            other.__dict__.pop(name, None)
        other.scale = scale
        other._spread_in = frozenset(self.spread) & frozenset(names)
        other.null = self.null * self.scale / scale
        other.null_replicates = self.null_replicates * self.scale / scale
        return other

    def renuisanced(self, hypothesis: Hypothesis) -> Problem:
        """The evidence with nuisances estimated anew beside a hypothesis; itself where all of them stay.

        Poses are first estimated within their priors, and then as far as captures disagree about them.
        """
        stated = of_each(partial(_renuisanced, hypothesis), self._stated)
        shares = _shares_of_priors(stated, hypothesis)
        if all(new is old for new, old in zip(stated, self._stated, strict=True)) and _are_close(
            shares, self._shares
        ):
            return self
        evidence = of_each(partial(_agreeing, shares), stated)
        other = copy(self)
        other.evidence, other._stated, other._shares = evidence, stated, shares
        other.null = _joined(of_each(partial(_residual, (), 1), evidence)) / self.scale
        other._kept, other._replicate_residuals = {}, {}
        return other

    def own_units(self, names: Collection[str]) -> NDArray[np.float64]:
        """(K,) noise floor of an explanation by some effects, in units of that of now.

        They differ by the effects of `spread`, by which frames differ by luck, as under lamps of unknown
        phase: numbers spread by these factors (K,) more with them.
        """
        units = np.ones(len(self.labels))
        for name, wider in self.spread.items():
            units *= wider ** (int(name in names) - int(name in self._spread_in))
        return units

    def averaging(self, draws: int) -> Problem:
        other = copy(self)
        other.draws = draws
        return other

    # what counts how much ---------------------------------------------------------------------------------

    @cached_property
    def weight(self) -> float:
        """Number of independent numbers that one of these is worth, as they vary together (Satterthwaite)."""
        squares = (robust(self.null_replicates) ** 2).sum(axis=1)
        least = LEAST_FLOOR**2 * len(self.labels)  # of numbers with hardly a noise floor, as if independent
        mean, spread = squares.mean() + least, squares.var(ddof=1) + 2 * LEAST_FLOOR**2 * least
        return float(np.clip(2 * mean / max(spread, 1e-9), 0.02, 1.0))

    @cached_property
    def noise_floor_rms(self) -> float:
        return floor_rms(self.null_replicates)

    def gap(self, z: NDArray[np.float64], part: NDArray[np.bool_] | None = None) -> float:
        """Root mean square residual, in units of that of the noise floor [noise floor]."""
        chosen = z if part is None else z[part]
        return float(np.sqrt(np.mean(chosen**2)) / self.noise_floor_rms) if chosen.size else 0.0

    @cached_property
    def null_gaps(self) -> NDArray[np.float64]:
        """(B,) gaps of the simulator against itself [noise floor]."""
        return np.array([self.gap(z) for z in self.null_replicates])

    @cached_property
    def fold(self) -> NDArray[np.bool_]:
        """(K,) which of two folds each number is in.

        Captures of a kind alternate, so that what is fitted on some levels, views or scenes is scored on
        others; a kind with a single capture is split by place, level and frequency.
        """
        fold = self.fold_within_captures.copy()
        order: dict[str, list[int]] = {}
        for i, evidence in enumerate(self.evidence):
            if evidence.labels:
                order.setdefault(evidence.labels[0].kind, []).append(i)
        for members in (m for m in order.values() if len(m) > 1):
            for place, i in enumerate(members):
                fold[self.slots[i].start : self.slots[i].stop] = place % 2 == 1
        return fold

    @cached_property
    def fold_within_captures(self) -> NDArray[np.bool_]:
        """(K,) which of two folds each number is in when every capture is split by place, level, frequency.

        What holds for one capture alone cannot be predicted from another. The places of a statistic are held
        out in whole parts, all channels of a place together.
        """
        places: dict[tuple[str, str], dict[str, int]] = {}
        found = []
        for label in self.labels:
            known = places.setdefault((label.capture, label.statistic), {})
            found.append(known.setdefault(_place(label), len(known)))
        fold = np.zeros(len(found), bool)
        for i, (label, place) in enumerate(zip(self.labels, found, strict=True)):
            count = len(places[label.capture, label.statistic])
            fold[i] = place * min(PLACES_APART, count) // count % 2 == 1
        return fold

    def held_parts(self, *, within_captures: bool = False) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """(K,) each: what is held out first, and what then.

        A number is in neither where the other fold has none of its statistic, as of a single dark the noise
        of its rows: nothing that was left could predict it.
        """
        fold = self.fold_within_captures if within_captures else self.fold
        keys = [(label.capture if within_captures else label.kind, label.statistic) for label in self.labels]
        seen: dict[tuple[str, str], set[bool]] = {}
        for key, part in zip(keys, fold.tolist(), strict=True):
            seen.setdefault(key, set()).add(part)
        has_both = np.array([len(seen[key]) == 2 for key in keys], bool)
        return fold & has_both, ~fold & has_both
