"""Which effects: forward selection with removals, scored on held-out conditions.

Of the effects that were screened only the most promising are fitted, round by round.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np

from tacos_gap.evidence import Judged
from tacos_gap.fit import Fitted, finished, fit, rescored
from tacos_gap.parameters import Term
from tacos_gap.problem import Hypothesis, Problem, bent
from tacos_gap.pruning import pruned
from tacos_gap.screening import Trials, in_units, promise, starts_of_all, try_all
from tacos_gap.unknown import block_index, unexplained

LARGEST = 3
"""Most effects in one explanation."""

PRICE = 6.0
"""What an effect must gain on held-out conditions to be believed in [nat]."""

LEAST_SHARE = 0.003
"""What it must gain over what all have gained so far: no model is exact, and a rest is always there."""

LEAST_CHANGE = 0.25
"""Mean square by which an effect must change some statistic of a capture; less is nobody's concern."""

TRIED = 4
"""Effects fitted in each round."""

WIDER = 3.0
"""Where an explanation spreads so much more than the simulator, as lamps do whose phase nobody knows, it was
judged in units too narrow and by the luck of one simulation: its fit begins anew."""

MANY = 0.05
"""Share of the numbers that must be so much wider."""

AVERAGED = 3
"""Simulations whose mean stands for such an explanation."""

_FORETOLD = 0.25
"""Share of its price that the trials of an effect must promise for it to be fitted beside others."""

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
        The evidence, in units of the floor of the explanation.
    """

    best: Fitted
    null: Fitted
    slots: Mapping[str, Mapping[str, float]]
    fits: Mapping[tuple[str, ...], Fitted]
    problem: Problem


class Search:
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
        self._trials: Trials = {}

    def run(self) -> Attribution:
        """Search, and compare what was found with its rivals."""
        null = fit(self.problem, ())
        assert null is not None
        self._fits[()] = null
        with ThreadPoolExecutor(self._workers) as pool:
            self._pool = pool
            best = null
            while True:
                best, judged = self._in_its_units(best)
                enough = len(best.hypothesis) == LARGEST
                if enough or not unexplained(self.problem, judged).stands_out:
                    break
                # where nothing stands out, nothing is tried
                self._trials = self._trials or try_all(self.problem, self._effects, pool.map)
                better = self._extended(best)
                if better is None:
                    break
                best = self._thinned(better)
                self._notify(" + ".join(best.names))
            for _ in range(LARGEST):
                best = self._cleaned(best)
                slots = {name: self._rivals(best, name) for name in best.names}
                better = self._better_rival(best, slots)
                if better is None:
                    break
                best = better
            best = finished(self.problem, best)
            return Attribution(best, self._fits[()], slots, self._fits, self.problem)

    def _in_its_units(self, best: Fitted) -> tuple[Fitted, Judged]:
        """An explanation in units of its own floor, and how it fares there."""
        before = self.problem.scale
        judged = self.problem.judged(best.hypothesis)
        best = self._in_units_of(judged, best)
        if best.hypothesis and np.mean(self.problem.scale > WIDER * before) > MANY:
            best = self._begun_anew(best)
            judged = self.problem.judged(best.hypothesis)
            best = self._in_units_of(judged, best)
        return best, judged

    def _in_units_of(self, judged: Judged, best: Fitted) -> Fitted:
        """Take the floor of the explanation so far for the unit; what was simulated is only rescaled."""
        before = self.problem.scale
        self.problem = self.problem.reweighted(np.maximum(judged.scale, 1.0))
        self._fits = {k: rescored(self.problem, fitted, before) for k, fitted in self._fits.items()}
        self._trials = in_units(self._trials, before / self.problem.scale)
        return self._fits[tuple(sorted(best.names))]

    def _begun_anew(self, best: Fitted) -> Fitted:
        """The explanation with its last effect fitted again, in the units of now, from each of its trials."""
        self.problem = self.problem.averaging(AVERAGED)
        *rest, last = best.hypothesis
        starts = [last, *starts_of_all(self._trials[last.name])]
        fits = self._pool.map(lambda start: fit(self.problem, (*rest, start)), starts)
        return self._kept(max((f for f in fits if f is not None), key=lambda fitted: fitted.score))

    def _kept(self, fitted: Fitted) -> Fitted:
        """The fit, which from now on stands for its set of effects."""
        self._fits[tuple(sorted(fitted.names))] = fitted
        return fitted

    # rounds -----------------------------------------------------------------------------------------------

    def _extended(self, base: Fitted) -> Fitted | None:
        """The best explanation with one more effect; None when none is worth its price."""
        least = _FORETOLD * self._price(base)
        tried = self._fitted(
            [(*base.hypothesis, start) for start in self._promising(base, TRIED, least=least)]
        )
        tried = [fitted for fitted in tried if self._shows(base, fitted)]
        if not tried:
            return None
        best = max(tried, key=lambda fitted: fitted.score)
        return best if best.score > base.score + self._price(best) else None

    def _shows(self, base: Fitted, fitted: Fitted) -> bool:
        """Whether what a fit changes is more than nobody's concern in any statistic of any capture.

        Thousands of pixels find a little of everything in every camera.
        """
        blocks = block_index(self.problem)
        change = np.bincount(blocks, (bent(fitted.z) - bent(base.z)) ** 2) / np.bincount(blocks)
        return bool(change.max() >= LEAST_CHANGE)

    def _price(self, fitted: Fitted) -> float:
        """What one more effect must gain [nat]."""
        return max(PRICE, LEAST_SHARE * (fitted.score - self._fits[()].score))

    def _promising(
        self, base: Fitted, count: int, without: Sequence[str] = (), least: float = 0.0
    ) -> list[Term]:
        """Starts of the effects that promise most on top of `base`, and more than `least` [nat]."""
        free = [name for name in self._trials if name not in base.names and name not in without]
        promises = sorted((promise(self._trials[name], base.z) for name in free), key=lambda p: -p.gain)
        worth = 0.5 * self.problem.weight
        return [each.start for each in promises[:count] if worth * each.gain > least]

    def _cleaned(self, fitted: Fitted) -> Fitted:
        """A fit led to its end, without parameters and effects that it does not need there."""
        ended = self._kept(finished(self.problem, fitted))
        return self._thinned(self._kept(pruned(self.problem, ended, least=self._price(ended) / 3)))

    def _thinned(self, fitted: Fitted) -> Fitted:
        """Without effects that another made superfluous."""
        for name in fitted.names:
            fewer = self._fitted([tuple(t for t in fitted.hypothesis if t.name != name)])
            if fewer and fewer[0].score > fitted.score - self._price(fitted):
                fitted = fewer[0]
        return fitted

    def _rivals(self, fitted: Fitted, name: str) -> dict[str, float]:
        """Scores with other effects in the place of `name`."""
        rest = tuple(term for term in fitted.hypothesis if term.name != name)
        (without,) = self._fitted([rest])
        starts = self._promising(without, TRIED, without=[name])
        scores = {name: fitted.score, "": without.score + PRICE}
        for rival in self._fitted([(*rest, start) for start in starts]):
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
