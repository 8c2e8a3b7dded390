"""Fits by their sets of effects, all in the units of one noise floor and beside the same nuisances."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
from numpy.typing import NDArray

from tacos_gap.inference.discrete import searched
from tacos_gap.inference.fit import Fitted, fit, rescored, settled
from tacos_gap.inference.problem import Hypothesis, Problem

CLOSE = 30.0
"""Effects whose first fits score so much less than another are no rivals of it [nat]; all others are
compared by several simulations."""


class Fits:
    """Fits hypotheses, each set of effects once."""

    def __init__(self, problem: Problem):
        self.problem = problem
        self.known: dict[tuple[str, ...], Fitted] = {}
        null = fit(problem, ())
        assert null is not None
        self.keep(null)

    @property
    def null(self) -> Fitted:
        return self.known[()]

    def take_as_units(self, scale: NDArray[np.float64], names: Collection[str]) -> None:
        """Count in units of another noise floor, that of some effects; simulations are only rescaled."""
        before = self.problem.scale
        self.problem = self.problem.reweighted(scale, names)
        self.known = {k: rescored(self.problem, fitted, before) for k, fitted in self.known.items()}

    def again(self, fitted: Fitted) -> Fitted:
        """The fit as it stands in the units of now, and beside the nuisances of now."""
        if _key(fitted.hypothesis) not in self.known:
            begun = fit(self.problem, fitted.hypothesis)
            assert begun is not None
            self.keep(settled(self.problem, begun))
        return self.known[_key(fitted.hypothesis)]

    def keep(self, fitted: Fitted) -> Fitted:
        self.known[_key(fitted.hypothesis)] = fitted
        return fitted

    def compared(self, hypotheses: Sequence[Hypothesis], near: Fitted) -> list[Fitted]:
        """Fits of which those that come close to the best, or to the fit nearby, are of several draws."""
        fits = self.fitted(hypotheses, near)
        best = max(fitted.score for fitted in (*fits, near))
        close = [fitted for fitted in fits if fitted.score > best - CLOSE]
        for each in close:
            self.keep(settled(self.problem, each))
        return [self.again(fitted) for fitted in fits]

    def fitted(self, hypotheses: Sequence[Hypothesis], near: Fitted) -> list[Fitted]:
        for hypothesis in hypotheses:
            if _key(hypothesis) not in self.known and (fitted := self._fit(hypothesis, near)) is not None:
                self.keep(fitted)
        return [self.known[_key(h)] for h in hypotheses if _key(h) in self.known]

    def _fit(self, hypothesis: Hypothesis, near: Fitted) -> Fitted | None:
        """A fit from what one nearby knows; where it ends below one of fewer effects, that misled it."""
        begun = searched(self.problem, hypothesis) if hypothesis else hypothesis
        found = fit(self.problem, begun, near=near)
        if found is None or found.cost <= self._least_of_fewer(hypothesis):
            return found
        return fit(self.problem, found.hypothesis)

    def _least_of_fewer(self, hypothesis: Hypothesis) -> float:
        names = {term.name for term in hypothesis}
        return min((fitted.cost for key, fitted in self.known.items() if names > set(key)), default=np.inf)

    def renuisanced(self, best: Fitted) -> Fitted:
        """An explanation fitted again where the nuisances of captures moved beside it.

        What was fitted beside others says nothing any more; the null is simulated anew.
        """
        moved = self.problem.renuisanced(best.hypothesis)
        if moved is self.problem:
            return best
        self.problem = moved
        refitted = fit(moved, best.hypothesis, near=best)
        self.known = {}
        for each in (fit(moved, ()), refitted):
            assert each is not None
            self.keep(settled(moved, each))
        return self.again(best)


def _key(hypothesis: Hypothesis) -> tuple[str, ...]:
    return tuple(sorted(term.name for term in hypothesis))
