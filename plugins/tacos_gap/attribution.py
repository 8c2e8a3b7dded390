"""Which effects: forward selection with removals, scored on held-out conditions.

Of the effects that were screened only those of the highest screening scores are fitted, round by round.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np

from tacos_gap.evidence import ReplicateResiduals
from tacos_gap.fit import Fitted, finished, fit, rescored
from tacos_gap.parameters import HypothesisTerm
from tacos_gap.problem import Hypothesis, Problem, robust
from tacos_gap.pruning import pruned
from tacos_gap.screening import ScreeningDirections, all_initial_guesses, in_units, screening_score, try_all
from tacos_gap.unknown import block_index, unexplained

LARGEST = 3
"""Most effects in one explanation."""

COMPLEXITY_PENALTY = 6.0
"""Complexity penalty: what an effect must gain in log score on held-out conditions [nat]."""

LEAST_SHARE = 0.003
"""What it must gain over what all have gained so far: no model is exact, and a rest is always there."""

LEAST_CHANGE = 0.25
"""Mean square by which an effect must change some statistic of a capture; less is negligible."""

TRIED = 4
"""Effects fitted in each round."""

WIDER = 3.0
"""Where an explanation spreads so much more than the simulator, as lamps of unknown phase do, it was scored
in units too narrow and by the luck of one simulation: its fit begins anew."""

MANY = 0.05
"""Share of the numbers that must be so much wider."""

AVERAGED = 3
"""Simulations whose mean stands for such an explanation."""

SCREENING_FRACTION = 0.25
"""Screening score, over the complexity penalty, above which an effect is fitted beside others."""

Notify = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class Attribution:
    """What was found.

    Parameters
    ----------
    best
        The explanation; an empty hypothesis where nothing is explained.
    null
        The hypothesis without effects.
    slots
        For each effect of `best`, the score of every effect tried in its place, itself included; ``""``
        stands for leaving it out [nat].
    fits
        All sets of effects that were fitted.
    problem
        The evidence, in units of the noise floor of the explanation.
    """

    best: Fitted
    null: Fitted
    slots: Mapping[str, Mapping[str, float]]
    fits: Mapping[tuple[str, ...], Fitted]
    problem: Problem


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
        self.problem = problem
        self._notify = notify or (lambda text: None)
        self._workers = workers
        self._effects = effects
        self._fits: dict[tuple[str, ...], Fitted] = {}
        self._directions: ScreeningDirections = {}

    def run(self) -> Attribution:
        """Search, and compare what was found with its rivals."""
        null = fit(self.problem, ())
        assert null is not None
        self._fits[()] = null
        with ThreadPoolExecutor(self._workers) as pool:
            self._pool = pool
            best = null
            while True:
                best, residuals = self._in_its_units(best)
                enough = len(best.hypothesis) == LARGEST
                if enough or not unexplained(self.problem, residuals).is_significant:
                    break
                # where nothing is significant, nothing is tried
                self._directions = self._directions or try_all(self.problem, self._effects, pool.map)
                better = self._extended(best)
                if better is None:
                    break
                best = self._backward_elimination(better)
                self._notify(" + ".join(best.names))
            for _ in range(LARGEST):
                best = self._pruned(best)
                slots = {name: self._rivals(best, name) for name in best.names}
                better = self._better_rival(best, slots)
                if better is None:
                    break
                best = better
            best = finished(self.problem, best)
            return Attribution(best, self._fits[()], slots, self._fits, self.problem)

    def _in_its_units(self, best: Fitted) -> tuple[Fitted, ReplicateResiduals]:
        """An explanation in units of its own noise floor, and how it fares there."""
        best = self._renuisanced(best)
        before = self.problem.scale
        residuals = self.problem.replicate_residuals(best.hypothesis)
        best = self._in_units_of(residuals, best)
        if best.hypothesis and np.mean(self.problem.scale > WIDER * before) > MANY:
            best = self._begun_anew(best)
            residuals = self.problem.replicate_residuals(best.hypothesis)
            best = self._in_units_of(residuals, best)
        return best, residuals

    def _renuisanced(self, best: Fitted) -> Fitted:
        """The explanation fitted again where the nuisances of captures moved beside it.

        What was fitted beside others says nothing any more; the null is simulated anew.
        """
        moved = self.problem.renuisanced(best.hypothesis)
        if moved is self.problem:
            return best
        self.problem = moved
        refitted = fit(moved, best.hypothesis)
        self._fits = {}
        for each in (fit(moved, ()), refitted):
            assert each is not None
            self._kept(each)
        assert refitted is not None
        return refitted

    def _in_units_of(self, residuals: ReplicateResiduals, best: Fitted) -> Fitted:
        """Take the noise floor of the explanation so far as the unit; simulations are only rescaled."""
        before = self.problem.scale
        self.problem = self.problem.reweighted(np.maximum(residuals.scale, 1.0))
        self._fits = {k: rescored(self.problem, fitted, before) for k, fitted in self._fits.items()}
        self._directions = in_units(self._directions, before / self.problem.scale)
        return self._fits[tuple(sorted(best.names))]

    def _begun_anew(self, best: Fitted) -> Fitted:
        """The explanation with its last effect fitted again, in the units of now, from each initial guess."""
        self.problem = self.problem.averaging(AVERAGED)
        *rest, last = best.hypothesis
        initial_guesses = [last, *all_initial_guesses(self._directions[last.name])]
        fits = self._pool.map(lambda guess: fit(self.problem, (*rest, guess)), initial_guesses)
        return self._kept(max((f for f in fits if f is not None), key=lambda fitted: fitted.score))

    def _kept(self, fitted: Fitted) -> Fitted:
        """The fit, which from now on stands for its set of effects."""
        self._fits[tuple(sorted(fitted.names))] = fitted
        return fitted

    # rounds -----------------------------------------------------------------------------------------------

    def _extended(self, base: Fitted) -> Fitted | None:
        """The best explanation with one more effect; None when none is worth its complexity penalty."""
        least = SCREENING_FRACTION * self._complexity_penalty(base)
        tried = self._fitted(
            [(*base.hypothesis, guess) for guess in self._screened(base, TRIED, least=least)]
        )
        tried = [fitted for fitted in tried if self._shows(base, fitted)]
        if not tried:
            return None
        best = max(tried, key=lambda fitted: fitted.score)
        return best if best.score > base.score + self._complexity_penalty(best) else None

    def _shows(self, base: Fitted, fitted: Fitted) -> bool:
        """Whether what a fit changes exceeds the equivalence margin in any statistic of any capture.

        Thousands of pixels find a little of everything in every camera.
        """
        blocks = block_index(self.problem)
        change = np.bincount(blocks, (robust(fitted.z) - robust(base.z)) ** 2) / np.bincount(blocks)
        return bool(change.max() >= LEAST_CHANGE)

    def _complexity_penalty(self, fitted: Fitted) -> float:
        """What one more effect must gain [nat]."""
        return max(COMPLEXITY_PENALTY, LEAST_SHARE * (fitted.score - self._fits[()].score))

    def _screened(
        self, base: Fitted, count: int, without: Sequence[str] = (), least: float = 0.0
    ) -> list[HypothesisTerm]:
        """Initial guesses of the effects with the highest screening scores on `base`, above `least` [nat]."""
        free = [name for name in self._directions if name not in base.names and name not in without]
        scores = sorted(
            (screening_score(self._directions[name], base.z) for name in free), key=lambda p: -p.gain
        )
        worth = 0.5 * self.problem.weight
        return [each.initial_guess for each in scores[:count] if worth * each.gain > least]

    def _pruned(self, fitted: Fitted) -> Fitted:
        """A converged fit, without parameters and effects that it does not need there."""
        ended = self._kept(finished(self.problem, fitted))
        return self._backward_elimination(
            self._kept(pruned(self.problem, ended, least=self._complexity_penalty(ended) / 3))
        )

    def _backward_elimination(self, fitted: Fitted) -> Fitted:
        """Backward elimination: without effects that another made superfluous."""
        for name in fitted.names:
            fewer = self._fitted([tuple(t for t in fitted.hypothesis if t.name != name)])
            if fewer and fewer[0].score > fitted.score - self._complexity_penalty(fitted):
                fitted = fewer[0]
        return fitted

    def _rivals(self, fitted: Fitted, name: str) -> dict[str, float]:
        """Scores with other effects in the place of `name`."""
        rest = tuple(term for term in fitted.hypothesis if term.name != name)
        (without,) = self._fitted([rest])
        initial_guesses = self._screened(without, TRIED, without=[name])
        scores = {name: fitted.score, "": without.score + COMPLEXITY_PENALTY}
        for rival in self._fitted([(*rest, guess) for guess in initial_guesses]):
            scores[rival.names[-1]] = rival.score
        return scores

    def _better_rival(self, best: Fitted, slots: Mapping[str, Mapping[str, float]]) -> Fitted | None:
        """The explanation with another effect in the first place where one turned out better."""
        for name, scores in slots.items():
            rival = max(scores, key=lambda key: scores[key])
            if rival not in ("", name) and rival not in best.names and scores[rival] > scores[name] + 1e-9:
                key = tuple(sorted(rival if other == name else other for other in best.names))
                return self._fits.get(key)
        return None

    def _fitted(self, hypotheses: Sequence[Hypothesis]) -> list[Fitted]:
        """Fit them, in parallel; each set of effects once."""
        wanted = [h for h in hypotheses if tuple(sorted(t.name for t in h)) not in self._fits]
        for fitted in self._pool.map(lambda h: fit(self.problem, h), wanted):
            if fitted is not None:
                self._fits[tuple(sorted(fitted.names))] = fitted
        keys = [tuple(sorted(t.name for t in h)) for h in hypotheses]
        return [self._fits[key] for key in keys if key in self._fits]
