"""Selection of effects: forward with removals, scored on held-out conditions.

Of the effects that were screened only those of the highest screening scores are fitted, round by round.
Where this ends with much unexplained, it is begun anew: with what differs from frame to frame by chance, and
with what a camera does to its files, all of it together, as of a processed camera no single effect is a good
explanation.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from tacos_framework import FILE_STAGES
from tacos_gap.attribution.fits import CLOSE
from tacos_gap.attribution.needed import hardly_needed, opens_again
from tacos_gap.attribution.result import Attribution
from tacos_gap.attribution.rounds import (
    LARGEST,
    MANY,
    SCREENING_FRACTION,
    SIMULATIONS,
    TRIED,
    WIDER,
    Notify,
    Rounds,
)
from tacos_gap.attribution.selection_rule import COMPLEXITY_PENALTY, least_of_a_rival, wins_by_width
from tacos_gap.inference.fit import Fitted, finished
from tacos_gap.inference.problem import Hypothesis, Problem, without
from tacos_gap.inference.pruning import restored
from tacos_gap.inference.screening import screening_score
from tacos_gap.inference.unknown import Unexplained, unexplained

MUCH = 0.4
"""Share of the gap left from which on effects on files are tried together."""

RIVALS_OF_A_SPENT_SEARCH = 1
"""Rivals of each effect that are fitted where the simulations are spent: what is left is said to be unknown
anyway, and the first rival says what an effect cannot be told from."""

LEAST_BETTER = 1e-9
"""Least gain of a rival that takes an effect's place [nat]: more than rounding. In a spent search it is that
of one out of reach (`CLOSE`), as what follows costs much."""

RIVALS = "comparing with rivals"
"""What is told once an explanation is found, and others are tried in its place."""


class ForwardSelection:
    """Looks for the effects behind a gap.

    `simulations`: those of all captures after which no further effect is looked for. `keep`: given each
    explanation as it is found, so that a search that is broken off can go on from there.
    """

    def __init__(
        self,
        problem: Problem,
        effects: Mapping[str, type[Any]],
        notify: Notify | None = None,
        simulations: int = SIMULATIONS,
        begun: Hypothesis = (),
        keep: Callable[[Hypothesis], None] | None = None,
    ):
        self._problem = problem
        self._begun = begun
        self._keep = keep or (lambda hypothesis: None)
        self._simulations = simulations
        self._notify = notify or (lambda text: None)
        self._effects = effects

    def run(self) -> Attribution:
        rounds = self._rounds = Rounds(
            self._problem, self._effects, self._notify, self._simulations, self._begun
        )
        best = self._explained(rounds.fits.null)
        self._keep(best.hypothesis)
        slots: dict[str, dict[str, Fitted]] = {}
        for _ in range(LARGEST if best.hypothesis else 0):
            self._notify(RIVALS)
            best = rounds.pruned(best)
            self._keep(best.hypothesis)
            slots = {name: self._rivals(best, name) for name in best.names}
            better = self._better_rival(slots, best.score + (CLOSE if rounds.cut_short else LEAST_BETTER))
            if better is None:
                break
            best = better
        best = restored(rounds.problem, finished(rounds.problem, best), COMPLEXITY_PENALTY / 3)
        whole = best
        while (fewer := self._with_one_less(best)) is not None:
            best = fewer
        if best is not whole:
            slots = {name: self._rivals(best, name) for name in best.names}
        found = Attribution.among(best, rounds.fits.null, slots, rounds.fits.known, rounds.problem)
        return replace(found, directions=rounds.directions, cut_short=rounds.cut_short)

    # one explanation, and another ---------------------------------------------------------------------------

    def _explained(self, null: Fitted) -> Fitted:
        """The best explanation from nothing on, or from another beginning where much stays unexplained."""
        rounds = self._rounds
        best, left = rounds.grown(null)
        if left.score >= 0.5 and not rounds.are_spent() and (chance := self._by_chance(best)):
            self._notify("what differs by chance")
            best, left = self._better_of(best, chance)
        if left.score < 0.5 or rounds.are_spent():
            return best
        if left.share < MUCH or len(self._on_files(rounds.fits.null)) < 2:
            return best
        self._notify("what the camera does to its files, together")
        block = rounds.through_files(rounds.fits.null)
        if set(block.names) <= set(best.names):
            return rounds.in_its_units(best)[0]
        return self._better_of(best, block)[0]

    def _better_of(self, best: Fitted, beginning: Fitted) -> tuple[Fitted, Unexplained]:
        """An explanation, or one from another beginning, in the wider of their units; and what it leaves."""
        rounds = self._rounds
        units = rounds.problem.scale
        other, _ = rounds.grown(beginning)
        rounds.take_as_units(np.maximum(units, rounds.problem.scale), {*best.names, *other.names})
        both = [rounds.fits.again(each) for each in (best, other)]
        both.sort(key=lambda fitted: COMPLEXITY_PENALTY * len(fitted.hypothesis) - fitted.score)
        better = both[wins_by_width(rounds.problem, *both)]
        rounds.forget_luck_but_of(better)
        better, residuals = rounds.in_its_units(better)
        return better, unexplained(rounds.problem, residuals)

    def _by_chance(self, best: Fitted) -> Fitted | None:
        """The best effect alone that another was preferred to in units too narrow for it; None where none is.

        A lamp of unknown phase makes every frame another: to one simulation the real frames are as unlike as
        to none, until its own spread is what is counted in.
        """
        rounds, null = self._rounds, self._rounds.fits.null
        others = [name for name in rounds.free(null) if name not in best.names]
        guesses = rounds.shortlisted(null, others, SCREENING_FRACTION * COMPLEXITY_PENALTY)
        fits = rounds.fits.compared([(guess,) for guess in guesses], near=null)
        alone = [fitted for fitted in fits if fitted.score > null.score + COMPLEXITY_PENALTY]
        for fitted in sorted(alone, key=lambda fitted: -fitted.score):
            own = rounds.problem.replicate_residuals(fitted.hypothesis).scale
            if np.mean(own > WIDER * rounds.problem.scale) > MANY:
                return fitted
        return None

    def _on_files(self, base: Fitted) -> list[str]:
        """Effects on files that could gain anything by themselves."""
        worth = 0.5 * self._rounds.problem.weight
        return [
            name
            for name, of_effect in self._rounds.directions.items()
            if self._effects[name].stage in FILE_STAGES
            and worth * screening_score(of_effect, base.z).gain > COMPLEXITY_PENALTY
        ]

    def _rivals(self, fitted: Fitted, name: str) -> dict[str, Fitted]:
        """Fits with other effects in the place of `name`, and with none."""
        rounds, rest = self._rounds, without(fitted.hypothesis, name)
        (fewer,) = rounds.fits.compared([rest], near=fitted)
        others = [free for free in rounds.free(fewer) if free != name]
        least = least_of_a_rival(fitted.score - fewer.score)
        most = RIVALS_OF_A_SPENT_SEARCH if rounds.cut_short else TRIED
        guesses = rounds.shortlisted(fewer, others, least)[:most]
        rivals = rounds.fits.compared([(*rest, guess) for guess in guesses], near=fitted)
        return {"": fewer, **{(set(rival.names) - set(fitted.names)).pop(): rival for rival in rivals}}

    def _with_one_less(self, best: Fitted) -> Fitted | None:
        """The explanation without an effect that it does as well without; None where it needs all."""
        for name in hardly_needed(self._rounds.problem, best):
            fewer = self._rounds.ended_without(best, name)
            if fewer is not None and not opens_again(self._rounds.problem, best, fewer):
                return fewer
        return None

    def _better_rival(self, slots: Mapping[str, Mapping[str, Fitted]], least: float) -> Fitted | None:
        """The explanation with another effect in the first place where one scores more than `least` [nat]."""
        for rivals in slots.values():
            named = [fitted for rival, fitted in rivals.items() if rival]
            if named and (first := max(named, key=lambda f: f.score)).score > least:
                return first
        return None
