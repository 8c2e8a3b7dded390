"""The whole selection, held out: its effects and their parameters."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_gap.attribution.result import Attribution
from tacos_gap.attribution.selection_rule import COMPLEXITY_PENALTY
from tacos_gap.inference.fit import Fitted, held_parts_for, move_of_fold, move_without, plain_jacobian
from tacos_gap.inference.problem import Problem, robust, without
from tacos_gap.inference.screening import columns_on, forms_of


@dataclass(frozen=True, eq=False)
class HeldOut:
    """Each fold, predicted by the effects and the parameters that the other fold alone would choose."""

    left: NDArray[np.float64]  # (K,) residuals that are left [noise floor]
    chosen: tuple[tuple[str, ...], ...]  # the effects, by each fold
    unseen: frozenset[str]
    """Effects that one fold does not show: it was given them, and they are not held out."""

    def why_not(self, effect: str) -> str:
        """Reason why an effect of the explanation is not held out from the selection; empty where it is."""
        if effect in self.unseen:
            return "half of the captures does not show it, and could not choose it"
        for names in self.chosen:
            if effect not in names:
                return f"half of the captures alone chooses {' and '.join(names)}"
        return ""


@dataclass(frozen=True, eq=False)
class _Prediction:
    """Residuals that one choice leaves of all numbers, its parameters chosen without those held out.

    Numbers are chosen by as robust ones, and judged as they are.
    """

    names: tuple[str, ...]
    left: NDArray[np.float64]
    parameters: float


def held_out(attribution: Attribution) -> HeldOut:
    """Choose again by each fold alone, among as many effects as the explanation has.

    All explanations that were fitted stand for election, and every effect that was not fitted in the place of
    another, to first order. They compete by their likelihood, less a nat for each parameter (Akaike 1974).
    """
    problem, best = attribution.problem, attribution.best
    left = best.z.copy()
    chosen, unseen = [], set()
    for held in held_parts_for(problem, best.hypothesis) if best.hypothesis else ():
        given = {name for name in best.names if not _shows(problem, best, name, ~held)}
        every = [p for p in _predictions(attribution, held) if given <= set(p.names)]
        first = min(
            every, key=lambda p: 0.5 * problem.weight * _squares(robust(p.left[~held])) + p.parameters
        )
        left[held] = first.left[held]
        chosen.append(first.names)
        unseen |= given
    return HeldOut(left, tuple(chosen), frozenset(unseen))


def _shows(problem: Problem, best: Fitted, name: str, seen: NDArray[np.bool_]) -> bool:
    """True if an effect changes some numbers by what could earn its penalty."""
    z = problem.residual(without(best.hypothesis, name))
    if z is None:
        return False
    return 0.5 * problem.weight * _squares((robust(z) - robust(best.z))[seen]) > COMPLEXITY_PENALTY


def _predictions(attribution: Attribution, held: NDArray[np.bool_]) -> Iterator[_Prediction]:
    """The explanation first, then its rivals."""
    best, fits = attribution.best, attribution.fits
    fitted = [f for f in fits.values() if len(f.names) == len(best.names) and set(f.names) != set(best.names)]
    for each in (best, *fitted):
        left = each.z + plain_jacobian(each) @ move_without(each, held)
        yield _Prediction(each.names, left, len(each.steps))
    tried = {frozenset(f.names) for f in (best, *fitted)}
    for name in best.names:
        rest = fits.get(tuple(sorted(set(best.names) - {name})))
        if rest is None:
            continue
        straight = robust(rest.z)
        for other, directions in attribution.directions.items():
            if other in best.names or frozenset((*rest.names, other)) in tried:
                continue
            for form in forms_of(directions):
                jacobian = np.hstack([rest.jacobian, columns_on(form, rest.z)])
                move = move_of_fold(jacobian[~held], straight[~held])
                changes = np.stack([direction.change for direction in form], axis=1)
                left = rest.z + np.hstack([plain_jacobian(rest), changes]) @ move
                yield _Prediction((*rest.names, other), left, len(move))


def _squares(straight: NDArray[np.float64]) -> float:
    return float(np.sum(straight**2))
