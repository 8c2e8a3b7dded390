"""Attribution: the explanation, and how every rival fares in the place of each effect."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from tacos_gap.attribution.selection_rule import COMPLEXITY_PENALTY
from tacos_gap.inference.fit import Fitted
from tacos_gap.inference.problem import Problem
from tacos_gap.inference.rivals import slot_probabilities, standard_error
from tacos_gap.inference.screening import ScreeningDirections


@dataclass(frozen=True, eq=False)
class Attribution:
    best: Fitted
    null: Fitted
    slots: Mapping[str, Mapping[str, float]]
    """For each effect of `best`, the score of every effect tried in its place, itself included; ``""`` stands
    for leaving it out [nat]."""
    fits: Mapping[tuple[str, ...], Fitted]
    problem: Problem  # the evidence, in units of the noise floor of the explanation
    errors: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    """Like `slots`, the standard error of each score's difference to that of the effect itself [nat]."""
    directions: ScreeningDirections = field(default_factory=dict)
    """What every effect that was screened changes, in the same units."""
    cut_short: bool = False  # whether no further effect was looked for as the simulations were spent

    @classmethod
    def among(
        cls,
        best: Fitted,
        null: Fitted,
        rivals: Mapping[str, Mapping[str, Fitted]],
        fits: Mapping[tuple[str, ...], Fitted],
        problem: Problem,
    ) -> Attribution:
        """An explanation among `rivals`: for each of its effects fits with another, or ``""``, instead."""
        scores: dict[str, dict[str, float]] = {}
        errors: dict[str, dict[str, float]] = {}
        for name, others in rivals.items():
            scores[name], errors[name] = {name: best.score}, {name: 0.0}
            for other, fitted in others.items():
                scores[name][other] = fitted.score + (0.0 if other else COMPLEXITY_PENALTY)
                errors[name][other] = standard_error(problem, best, fitted)
        return cls(best, null, scores, fits, problem, errors)

    def probabilities(self, name: str) -> dict[str, float]:
        """Probability of each effect that was tried in the place of one; empty where it is not of `best`."""
        return slot_probabilities(self.slots.get(name, {}), self.errors.get(name, {}))
