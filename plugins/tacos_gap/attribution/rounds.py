"""Rounds of forward selection: one more effect or two, removals, and the units that all is counted in."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework import FILE_STAGES, EffectBase, optional
from tacos_gap.attribution.fits import Fits
from tacos_gap.attribution.needed import is_plainly_needed
from tacos_gap.attribution.pairs import best_pair
from tacos_gap.attribution.selection_rule import (
    COMPLEXITY_PENALTY,
    fits_a_bit,
    gains_in_width,
    is_worth_it,
    least_gain,
    shows,
)
from tacos_gap.attribution.shortlist import shortlist
from tacos_gap.evidence import Evidence, PictureEvidence, ReplicateResiduals
from tacos_gap.hypotheses.parameters import HypothesisTerm
from tacos_gap.inference.alternative_guesses import in_its_best_form
from tacos_gap.inference.codec import codec_of_files
from tacos_gap.inference.discrete_refits import in_other_words, to_the_digit
from tacos_gap.inference.fit import Fitted, finished, fit, rescored
from tacos_gap.inference.problem import Hypothesis, Problem, robust, without
from tacos_gap.inference.pruning import pruned as less_parameters
from tacos_gap.inference.screening import (
    ScreeningDirections,
    all_initial_guesses,
    in_units,
    screening_score,
    try_all,
)
from tacos_gap.inference.unknown import Unexplained, unexplained

LARGEST = 6
"""Most effects in one explanation: shares of more cannot be enumerated."""

SIMULATIONS = 2000
"""Simulations of all captures after which no further effect is looked for. What has a good explanation mostly
takes some hundred; a longer search adds effect to effect that each fit a bit of what none explains."""

LEAST_SIMULATIONS = 200
AFFORDABLE_SAMPLES = 600_000_000
"""Samples that all these simulations may have, of large folders too: a minute of two cores or less."""

LEAST_SHARE = 0.001
"""What one more parameter must gain, a third of the penalty aside, over what all have gained."""

TRIED = 4
"""Effects fitted in each round."""

WIDER = 3.0
"""Where an explanation spreads so much more than the simulator, as lamps of unknown phase do, it was scored
in units too narrow and by the luck of one simulation: its fit begins anew."""

MANY = 0.05
"""Share of the numbers that must be so much wider."""

BEST_GUESSES = 2
"""Initial guesses that fits begin at where every simulation is worth several."""

ASKED_AGAIN = 0.5
"""Cost of an explanation, over that beside which an effect of luck was refused, at which it is tried anew."""

AVERAGED = 3
"""Simulations whose mean stands for such an explanation while it is fitted."""

SCREENING_FRACTION = 0.25
"""Screening score, over the complexity penalty, above which an effect is fitted beside others."""

Notify = Callable[[str], None]


def affordable_simulations(evidence: Sequence[Evidence]) -> int:
    """Number of simulations of all captures made before no further effect is looked for."""
    samples = sum(each.capture.real_dn.size for each in evidence if isinstance(each, PictureEvidence))
    return min(SIMULATIONS, max(LEAST_SIMULATIONS, AFFORDABLE_SAMPLES // max(samples, 1)))


def looking_beside(found: Fitted) -> str:
    """What is told while more is looked for, from the effects that were found."""
    return f"looking beside {' + '.join(found.names)}"


class Rounds:
    """Knowledge of the effects by now, and one round after another.

    `simulations`: how many of all captures may be made from now on before no further effect is looked for.
    `begun`: effects that selection begins with, where they explain more than nothing does.
    """

    def __init__(
        self,
        problem: Problem,
        effects: Mapping[str, type[Any]],
        notify: Notify,
        simulations: int,
        begun: Hypothesis = (),
    ):
        self._begun = begun
        self._last = problem.simulations + simulations
        self.fits = Fits(problem)
        self.effects = effects
        self.directions: ScreeningDirections = {}
        self.notify = notify
        self.cut_short = False
        self._refused: dict[str, float] = {}  # effects of luck, and the cost of what they were refused beside

    def are_spent(self) -> bool:
        """True if all simulations were made, so that no further effect is looked for: it is cut short."""
        self.cut_short |= self.problem.simulations >= self._last
        return self.cut_short

    @property
    def problem(self) -> Problem:
        """The evidence, in the units of now."""
        return self.fits.problem

    def grown(self, best: Fitted) -> tuple[Fitted, Unexplained]:
        """Forward selection from an explanation on, and what it leaves; one that comes back ends it."""
        seen: set[frozenset[str]] = set()
        while True:
            best, residuals = self.in_its_units(best)
            left = unexplained(self.problem, residuals)
            if len(best.hypothesis) == LARGEST or not left.is_significant:
                return best, left  # where nothing is significant, nothing is tried
            if self.are_spent():
                return best, left
            if not self.directions:
                self.directions = try_all(self.problem, self.effects)
                if codec := codec_of_files(self.problem, self.directions):
                    best = self.fits.fitted([codec], near=best)[0]
                    self.notify(looking_beside(best))
                    continue
            if self._begun and (first := self._with_begun(best)) is not None:
                best = first
                self.notify(looking_beside(best))
                continue
            is_new = frozenset(best.names) not in seen
            better = self._extended(best, is_rest=left.score == 0.0) if is_new else None
            if better is None:
                return best, left
            seen.add(frozenset(best.names))
            best = self.backward_elimination(better)
            self.notify(looking_beside(best))

    def _with_begun(self, base: Fitted) -> Fitted | None:
        """An explanation with those effects to begin with that it needs; None where it needs none."""
        more, self._begun = [term for term in self._begun if term.name not in base.names], ()
        hypothesis = (*base.hypothesis, *more)[:LARGEST]
        if len(hypothesis) == len(base.hypothesis):
            return None
        fits = self.fits.fitted([hypothesis], near=base)
        if not fits or fits[0].score <= base.score:
            return None
        kept = self.backward_elimination(fits[0])
        return kept if len(kept.hypothesis) > len(base.hypothesis) else None

    def through_files(self, base: Fitted) -> Fitted:
        """Effects on files alone, as many as pay."""
        among = {name for name in self.directions if self.effects[name].stage in FILE_STAGES}
        while len(base.hypothesis) < LARGEST and (better := self._extended(base, among)) is not None:
            base = self.backward_elimination(better)
        return base

    # units --------------------------------------------------------------------------------------------------

    def in_its_units(self, best: Fitted) -> tuple[Fitted, ReplicateResiduals]:
        """An explanation in units of its own noise floor, and how it fares there."""
        best = self.fits.renuisanced(best)
        before = self.problem.scale
        residuals = self.problem.replicate_residuals(best.hypothesis)
        in_own_units = best.names[-1:] and best.names[-1] in self.problem.spread  # see `_in_own_units`
        self._note_what_spreads(best.hypothesis)
        self.take_as_units(np.maximum(residuals.scale, 1.0), best.names)
        best = self.fits.again(best)
        if best.hypothesis and self.directions and np.mean(self.problem.scale > WIDER * before) > MANY:
            self.fits.problem = self.problem.averaging(AVERAGED)
            if in_own_units:
                return best, residuals
            best = self.fits.keep(self._from_best_guesses(self.problem, best.hypothesis))
            residuals = self.problem.replicate_residuals(best.hypothesis)
            self.take_as_units(np.maximum(residuals.scale, 1.0), best.names)
            best = self.fits.again(best)
        return best, residuals

    def _note_what_spreads(self, hypothesis: Hypothesis) -> None:
        """Keep by how much more numbers spread with each effect by which frames differ by luck."""
        for name in {term.name for term in hypothesis if _is_of_luck(term)} - self.problem.spread.keys():
            floors = (
                np.maximum(self.problem.replicate_residuals(each).scale, 1.0)
                for each in (hypothesis, without(hypothesis, name))
            )
            self.problem.spread[name] = np.divide(*floors)

    def _in_own_units(self, base: Fitted, fitted: Fitted) -> Fitted | None:
        """A fit with a last effect of luck, from the best guesses, in units of its own noise floor.

        In narrower ones it would be fitted to the luck of one simulation. None where it gains too little in
        these units: what is far off seems likelier the wider numbers spread, whatever spreads them.
        """
        term = fitted.hypothesis[-1]
        if not _is_of_luck(term):
            return fitted
        if base.cost > ASKED_AGAIN * self._refused.get(term.name, np.inf):
            return None
        self._note_what_spreads(fitted.hypothesis)
        scale = self.problem.scale * self.problem.own_units(fitted.names)
        wide = self.problem.averaging(AVERAGED).reweighted(scale, fitted.names)
        best = self._from_best_guesses(wide, fitted.hypothesis)
        without_it = base.held_out * self.problem.scale / scale
        if not gains_in_width(wide, without_it, best.held_out):
            self.forget_luck_but_of(base)
            self._refused[term.name] = base.cost
            return None
        return self.fits.keep(rescored(self.problem, best, wide.scale))

    def forget_luck_but_of(self, best: Fitted) -> None:
        """Hold effects of luck that an explanation does without to the units of all others, from now on."""
        for name in self.problem.spread.keys() - set(best.names):
            del self.problem.spread[name]

    def take_as_units(self, scale: NDArray[np.float64], names: Collection[str]) -> None:
        """Count in units of another noise floor, that of some effects; simulations are only rescaled."""
        before = self.problem.scale
        self.fits.take_as_units(scale, names)
        self.directions = in_units(self.directions, before / self.problem.scale)

    def _from_best_guesses(self, problem: Problem, hypothesis: Hypothesis) -> Fitted:
        """The best fit with the last effect begun as it stands, or at an initial guess that leaves little."""
        *rest, last = hypothesis
        begun = [(*rest, guess) for guess in (last, *all_initial_guesses(self.directions[last.name]))]
        left = zip(map(problem.residual, begun), begun, strict=True)
        costs = [(float(np.sum(robust(z) ** 2)), each) for z, each in left if z is not None]
        nearest = [each for _, each in sorted(costs, key=lambda pair: pair[0])[:BEST_GUESSES]]
        fits = [fit(problem, each) for each in nearest]
        return max((fitted for fitted in fits if fitted is not None), key=lambda fitted: fitted.score)

    # rounds -----------------------------------------------------------------------------------------------

    def _extended(
        self, base: Fitted, among: Collection[str] | None = None, *, is_rest: bool = False
    ) -> Fitted | None:
        """The best explanation with one more effect, or two; None when none is worth its penalty.

        `is_rest`: true if the base leaves so little that nothing is unknown: then effects must prove
        themselves.
        """
        least = SCREENING_FRACTION * COMPLEXITY_PENALTY
        guesses = self.shortlisted(base, self.free(base, among), least)
        tried = self.fits.compared([(*base.hypothesis, guess) for guess in guesses], near=base)
        shown = [fitted for fitted in tried if shows(self.problem, base, fitted)]
        own = (self._in_own_units(base, fitted) for fitted in shown)
        tried = [fitted for fitted in own if fitted is not None]
        if not tried:
            return None
        best = max(tried, key=lambda fitted: fitted.score)
        two = self._two_at_once(base, best, among)
        if two is not None and not (is_rest and fits_a_bit(self.problem, base, two)):
            return two
        if is_rest:
            tried = [fitted for fitted in tried if not fits_a_bit(self.problem, base, fitted)]
            best = max(tried, key=lambda fitted: fitted.score, default=base)
        if best is base or not is_worth_it(self.problem, base, best):
            return None
        guesses = all_initial_guesses(self.directions[best.names[-1]])
        return self.fits.keep(in_its_best_form(self.problem, best, guesses, COMPLEXITY_PENALTY / 3))

    def _two_at_once(self, base: Fitted, best: Fitted, among: Collection[str] | None) -> Fitted | None:
        """Two effects, each needed beside the other, that beat the best single one; None where none do."""
        if len(best.hypothesis) == LARGEST:
            return None
        alone = screening_score(self.directions[best.names[-1]], base.z).gain
        pair = best_pair(self.directions, self.free(best, among), base.z)
        if pair is None or 0.5 * self.problem.weight * (pair.gain - alone) < 2 * COMPLEXITY_PENALTY:
            return None
        for two in self.fits.compared([(*base.hypothesis, *pair.terms)], near=base):
            if two.score - best.score > 2 * COMPLEXITY_PENALTY and is_worth_it(self.problem, best, two):
                kept = self.backward_elimination(two)
                return kept if {term.name for term in pair.terms} <= set(kept.names) else None
        return None

    def shortlisted(self, base: Fitted, names: Sequence[str], least: float) -> list[HypothesisTerm]:
        """Beginnings of fits of those effects that promise most on a base, and `least` at least [nat]."""
        return shortlist(self.problem, self.directions, base, names, count=TRIED, least=least)

    def free(self, base: Fitted, among: Collection[str] | None = None) -> list[str]:
        wanted = self.directions if among is None else among
        return [name for name in self.directions if name in wanted and name not in base.names]

    def pruned(self, fitted: Fitted) -> Fitted:
        """A converged fit, without parameters and effects that it does not need there."""
        ended = to_the_digit(self.problem, finished(self.problem, fitted))
        ended = self.fits.keep(in_other_words(self.problem, ended, COMPLEXITY_PENALTY))
        least = max(COMPLEXITY_PENALTY / 3, LEAST_SHARE * (ended.score - self.fits.null.score))
        return self.backward_elimination(self.fits.keep(less_parameters(self.problem, ended, least)))

    def backward_elimination(self, fitted: Fitted) -> Fitted:
        """Backward elimination: without effects that another made superfluous."""
        least = least_gain(self.problem, fitted)
        doubtful = [n for n in fitted.names if not is_plainly_needed(self.problem, fitted, n, least)]
        self.fits.compared([without(fitted.hypothesis, name) for name in doubtful], near=fitted)
        for name in doubtful:
            fewer = self.fits.compared([without(fitted.hypothesis, name)], near=fitted)
            if fewer and not is_worth_it(self.problem, fewer[0], fitted):
                fitted = fewer[0]
        return fitted

    def ended_without(self, fitted: Fitted, name: str) -> Fitted | None:
        """The explanation less one effect, fitted to its end; None where it cannot be simulated without."""
        fewer = self.fits.compared([without(fitted.hypothesis, name)], near=fitted)
        if not fewer:
            return None
        return finished(self.problem, fewer[0]) if fewer[0].hypothesis else self.fits.null


def _is_of_luck(term: HypothesisTerm) -> bool:
    return bool(optional(term.cls, EffectBase, "frames_differ"))
