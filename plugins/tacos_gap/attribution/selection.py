"""Which effects: forward selection with removals, scored on held-out conditions.

Of the effects that were screened only those of the highest screening scores are fitted, round by round.
Where this ends with much unexplained, it is begun anew with what a camera does to its files, all of it
together: of a processed camera no single effect is a good explanation.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework.contracts import FILE_STAGES
from tacos_gap.attribution.fits import Fits
from tacos_gap.attribution.found import Attribution
from tacos_gap.attribution.pairs import best_pair
from tacos_gap.attribution.shortlist import shortlist
from tacos_gap.attribution.worth import COMPLEXITY_PENALTY, is_worth_it, least_of_a_rival, shows
from tacos_gap.codec import codec_of_files
from tacos_gap.discrete import searched
from tacos_gap.evidence import ReplicateResiduals
from tacos_gap.fit import DRAWS, Fitted, finished, fit
from tacos_gap.forms import in_its_best_form
from tacos_gap.parameters import HypothesisTerm
from tacos_gap.problem import Hypothesis, Problem
from tacos_gap.pruning import pruned, restored
from tacos_gap.rivals import standard_error
from tacos_gap.screening import ScreeningDirections, all_initial_guesses, in_units, screening_score, try_all
from tacos_gap.unknown import Unexplained, unexplained

LARGEST = 6
"""Most effects in one explanation: shares of more cannot be enumerated."""

MUCH = 0.4
"""Share of the gap left from which on effects on files are tried together."""

LEAST_SHARE = 0.001
"""What one more parameter must gain, a third of the penalty aside, over what all have gained."""

TRIED = 4
"""Effects fitted in each round."""

WIDER = 3.0
"""Where an explanation spreads so much more than the simulator, as lamps of unknown phase do, it was scored
in units too narrow and by the luck of one simulation: its fit begins anew."""

MANY = 0.05
"""Share of the numbers that must be so much wider."""

AVERAGED = 3
"""Simulations whose mean stands for such an explanation while it is fitted."""

SCREENING_FRACTION = 0.25
"""Screening score, over the complexity penalty, above which an effect is fitted beside others."""

RIVALS = "comparing with rivals"
"""What is told once an explanation is found, and others are tried in its place."""

Notify = Callable[[str], None]


class ForwardSelection:
    """Looks for the effects behind a gap.

    Parameters
    ----------
    problem
        The evidence.
    effects
        Name and class of every candidate.
    workers
        Threads.
    notify
        Told what is being done.
    """

    def __init__(
        self,
        problem: Problem,
        effects: Mapping[str, type[Any]],
        workers: int = 2,
        notify: Notify | None = None,
    ):
        self._problem = problem
        self._notify = notify or (lambda text: None)
        self._workers = workers
        self._effects = effects
        self._directions: ScreeningDirections = {}

    @property
    def problem(self) -> Problem:
        """The evidence, in the units of now."""
        return self._fits.problem

    def run(self) -> Attribution:
        """Search, and compare what was found with its rivals."""
        with ThreadPoolExecutor(self._workers) as pool:
            self._each = pool.map
            self._fits = Fits(self._problem, pool.map)
            best = self._explained(self._fits.null)
            slots: dict[str, dict[str, Fitted]] = {}
            for _ in range(LARGEST if best.hypothesis else 0):
                self._notify(RIVALS)
                best = self._pruned(best)
                slots = {name: self._rivals(best, name) for name in best.names}
                better = self._better_rival(best, slots)
                if better is None:
                    break
                best = better
            best = restored(self.problem, finished(self.problem, best), COMPLEXITY_PENALTY / 3)
            return self._attribution(best, slots)

    def _attribution(self, best: Fitted, slots: Mapping[str, Mapping[str, Fitted]]) -> Attribution:
        scores: dict[str, dict[str, float]] = {}
        errors: dict[str, dict[str, float]] = {}
        for name, rivals in slots.items():
            scores[name], errors[name] = {name: best.score}, {name: 0.0}
            for rival, fitted in rivals.items():
                scores[name][rival] = fitted.score + (0.0 if rival else COMPLEXITY_PENALTY)
                errors[name][rival] = standard_error(self.problem, best, fitted)
        return Attribution(best, self._fits.null, scores, self._fits.known, self.problem, errors)

    # one explanation, and another ---------------------------------------------------------------------------

    def _explained(self, null: Fitted) -> Fitted:
        """The best explanation from nothing on, or from effects on files where much stays unexplained."""
        best, left = self._grown(null)
        if left.probability < 0.5 or left.share < MUCH or len(self._on_files(null)) < 2:
            return best
        self._notify("what the camera does to its files, together")
        units = self.problem.scale
        block = self._through_files(null)
        if set(block.names) <= set(best.names):
            return self._in_its_units(best)[0]
        other, _ = self._grown(block)
        self._take_as_units(np.maximum(units, self.problem.scale))
        both = [self._fits.again(each) for each in (best, other)]
        better = max(both, key=lambda fitted: fitted.score - COMPLEXITY_PENALTY * len(fitted.hypothesis))
        return self._in_its_units(better)[0]

    def _grown(self, best: Fitted) -> tuple[Fitted, Unexplained]:
        """Forward selection from an explanation on, and what it leaves; one that comes back ends it."""
        seen: set[frozenset[str]] = set()
        while True:
            best, residuals = self._in_its_units(best)
            left = unexplained(self.problem, residuals)
            if len(best.hypothesis) == LARGEST or not left.is_significant:
                return best, left  # where nothing is significant, nothing is tried
            if not self._directions:
                self._directions = try_all(self.problem, self._effects, self._each)
                if codec := codec_of_files(self.problem, self._directions):
                    best = self._fits.fitted([codec], near=best)[0]
                    self._notify(" + ".join(best.names))
                    continue
            better = None if frozenset(best.names) in seen else self._extended(best)
            if better is None:
                return best, left
            seen.add(frozenset(best.names))
            best = self._backward_elimination(better)
            self._notify(" + ".join(best.names))

    def _on_files(self, base: Fitted) -> list[str]:
        """Effects on files that could gain anything by themselves."""
        worth = 0.5 * self.problem.weight
        return [
            name
            for name, of_effect in self._directions.items()
            if self._effects[name].stage in FILE_STAGES
            and worth * screening_score(of_effect, base.z).gain > COMPLEXITY_PENALTY
        ]

    def _through_files(self, base: Fitted) -> Fitted:
        """Effects on files alone, as many as pay."""
        among = {name for name in self._directions if self._effects[name].stage in FILE_STAGES}
        while len(base.hypothesis) < LARGEST and (better := self._extended(base, among)) is not None:
            base = self._backward_elimination(better)
        return base

    # units --------------------------------------------------------------------------------------------------

    def _in_its_units(self, best: Fitted) -> tuple[Fitted, ReplicateResiduals]:
        """An explanation in units of its own noise floor, and how it fares there."""
        best = self._fits.renuisanced(best)
        before = self.problem.scale
        residuals = self.problem.replicate_residuals(best.hypothesis)
        self._take_as_units(np.maximum(residuals.scale, 1.0))
        best = self._fits.again(best)
        if best.hypothesis and self._directions and np.mean(self.problem.scale > WIDER * before) > MANY:
            best = self._begun_anew(best)
            residuals = self.problem.replicate_residuals(best.hypothesis)
            self._take_as_units(np.maximum(residuals.scale, 1.0))
            best = self._fits.again(best)
        return best, residuals

    def _take_as_units(self, scale: NDArray[np.float64]) -> None:
        """Count in units of another noise floor; simulations are only rescaled."""
        before = self.problem.scale
        self._fits.take_as_units(scale)
        self._directions = in_units(self._directions, before / self.problem.scale)

    def _begun_anew(self, best: Fitted) -> Fitted:
        """The explanation with its last effect fitted again, in the units of now, from each initial guess."""
        self._fits.problem = self.problem.averaging(AVERAGED)
        *rest, last = best.hypothesis
        initial_guesses = [last, *all_initial_guesses(self._directions[last.name])]
        fits = self._each(lambda guess: fit(self.problem, (*rest, guess)), initial_guesses)
        return self._fits.keep(max((f for f in fits if f is not None), key=lambda fitted: fitted.score))

    # rounds -----------------------------------------------------------------------------------------------

    def _extended(self, base: Fitted, among: Collection[str] | None = None) -> Fitted | None:
        """The best explanation with one more effect, or two; None when none is worth its penalty."""
        least = SCREENING_FRACTION * COMPLEXITY_PENALTY
        guesses = self._shortlist(base, self._free(base, among), least)
        tried = self._fits.compared([(*base.hypothesis, guess) for guess in guesses], near=base)
        tried = [fitted for fitted in tried if shows(self.problem, base, fitted)]
        if not tried:
            return None
        best = max(tried, key=lambda fitted: fitted.score)
        if (two := self._two_at_once(base, best, among)) is not None:
            return two
        if not is_worth_it(self.problem, base, best):
            return None
        guesses = all_initial_guesses(self._directions[best.names[-1]])
        return self._fits.keep(in_its_best_form(self.problem, best, guesses, COMPLEXITY_PENALTY / 3))

    def _two_at_once(self, base: Fitted, best: Fitted, among: Collection[str] | None) -> Fitted | None:
        """Two effects, each needed beside the other, that beat the best single one; None where none do."""
        if len(best.hypothesis) == LARGEST:
            return None
        alone = screening_score(self._directions[best.names[-1]], base.z).gain
        pair = best_pair(self._directions, self._free(best, among), base.z)
        if pair is None or 0.5 * self.problem.weight * (pair.gain - alone) < 2 * COMPLEXITY_PENALTY:
            return None
        for two in self._fits.compared([(*base.hypothesis, *pair.terms)], near=base):
            if two.score - best.score > 2 * COMPLEXITY_PENALTY and is_worth_it(self.problem, best, two):
                kept = self._backward_elimination(two)
                return kept if {term.name for term in pair.terms} <= set(kept.names) else None
        return None

    def _shortlist(self, base: Fitted, names: Sequence[str], least: float = 0.0) -> list[HypothesisTerm]:
        return shortlist(
            self.problem, self._directions, base, names, count=TRIED, least=least, each=self._each
        )

    def _free(self, base: Fitted, among: Collection[str] | None = None) -> list[str]:
        """Effects that were screened and are not yet in an explanation."""
        wanted = self._directions if among is None else among
        return [name for name in self._directions if name in wanted and name not in base.names]

    def _pruned(self, fitted: Fitted) -> Fitted:
        """A converged fit, without parameters and effects that it does not need there."""
        ended = self._fits.keep(self._to_the_digit(finished(self.problem, fitted)))
        least = max(COMPLEXITY_PENALTY / 3, LEAST_SHARE * (ended.score - self._fits.null.score))
        return self._backward_elimination(self._fits.keep(pruned(self.problem, ended, least)))

    def _to_the_digit(self, fitted: Fitted) -> Fitted:
        """A fit whose discrete settings are the best of their neighbours, by several simulations."""
        averaged = self.problem.averaging(max(DRAWS, self.problem.draws))
        hypothesis = fitted.hypothesis
        for name in fitted.names:
            term = next(term for term in hypothesis if term.name == name)
            hypothesis = searched(averaged, (*_without(hypothesis, name), term), farthest=1)
        if {term.name: term for term in hypothesis} == {term.name: term for term in fitted.hypothesis}:
            return fitted
        begun = fit(self.problem, hypothesis, near=fitted)
        return fitted if begun is None else max(fitted, finished(self.problem, begun), key=lambda f: f.score)

    def _backward_elimination(self, fitted: Fitted) -> Fitted:
        """Backward elimination: without effects that another made superfluous."""
        for name in fitted.names:
            fewer = self._fits.compared([_without(fitted.hypothesis, name)], near=fitted)
            if fewer and not is_worth_it(self.problem, fewer[0], fitted):
                fitted = fewer[0]
        return fitted

    def _rivals(self, fitted: Fitted, name: str) -> dict[str, Fitted]:
        """Fits with other effects in the place of `name`, and with none."""
        rest = _without(fitted.hypothesis, name)
        (without,) = self._fits.compared([rest], near=fitted)
        others = [free for free in self._free(without) if free != name]
        guesses = self._shortlist(without, others, least_of_a_rival(fitted.score - without.score))
        rivals = self._fits.compared([(*rest, guess) for guess in guesses], near=fitted)
        return {"": without, **{(set(rival.names) - set(fitted.names)).pop(): rival for rival in rivals}}

    def _better_rival(self, best: Fitted, slots: Mapping[str, Mapping[str, Fitted]]) -> Fitted | None:
        """The explanation with another effect in the first place where one turned out better."""
        for rivals in slots.values():
            named = [fitted for rival, fitted in rivals.items() if rival]
            if named and (first := max(named, key=lambda f: f.score)).score > best.score + 1e-9:
                return first
        return None


def _without(hypothesis: Hypothesis, name: str) -> Hypothesis:
    return tuple(term for term in hypothesis if term.name != name)
