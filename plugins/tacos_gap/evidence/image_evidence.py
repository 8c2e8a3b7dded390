"""Captures turned into standardised differences between the real camera and a simulation of it.

The noise floor is the simulator's own: the same captures simulated many times over with other noise. What
differs by less than that, or by less than the equivalence margin of its statistic, is no gap.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework import generator
from tacos_framework.formation import PlacedEffect
from tacos_gap.captures import RealCapture
from tacos_gap.evidence.contract import N_NULL_REPLICATES, Label, PictureEvidence, ReplicateResiduals
from tacos_gap.evidence.moved_expectation import MovedExpectation, MovedExpectations
from tacos_gap.evidence.simulated_statistics import SimulatedStatistics
from tacos_gap.nuisances import POSE_TERMS, Marginal, disturbed, freedoms_of, registered, stated

N_REPLICATES = 16
"""Simulated replicates that the noise floor of a hypothesis is made of."""

FARTHEST = 3.0
"""How far nuisances are followed; beyond it the linear part must do [standard deviations of their priors]."""

NEARBY = 0.25
"""A move of all nuisances by less is none: the linear part is as good [standard deviations]."""

BETTER = 0.75
"""What is left of the cost of a capture where nuisances alone explain it: an effect not yet found must not
drag the expectation about."""

_DIFFERENCE = 0.5  # step of the derivatives [standard deviations]
_LUCK_DRAWS = 8
_BASE_DRAWS = 4  # simulations whose mean tells what a move of the expectation changes

SPREAD_OF_ONE = 1.5
"""Variance of real less simulated over that of real alone: the simulated mean is not known exactly."""


class ImageEvidence(PictureEvidence):
    """Statistics of a capture with expected values.

    Its nuisances (light, pose and focus of the expectation) are integrated out around the values that the
    explanation so far asks for, at which the expectation really is moved, blurred and lit, before any effect
    acts on it; see `renuisanced`.

    `replicates`: simulations the noise floor is made of.
    """

    def __init__(self, capture: RealCapture, seed: int, replicates: int = N_NULL_REPLICATES):
        assert capture.expected_dn is not None
        self.capture = capture
        self._seed = seed
        self._freedoms = freedoms_of(capture)
        self._nu = np.zeros(len(self._freedoms))
        first = SimulatedStatistics(capture, capture, seed)
        every = first.taken
        draws = np.stack([first.of((), draw) for draw in range(replicates)])
        luck = _variance_with_noise(first)
        self._taken = every.finite_in(draws)
        kept = self._taken.kept[every.kept]
        draws, self._luck = draws[:, kept], luck[kept]
        self._draws = draws
        self.mean = draws.mean(axis=0)
        self._floor = self._sigma(draws)
        real = self._taken.values(self._taken.blocks)
        self._there = MovedExpectation(first.taking(self._taken, kept), real, draws)
        self._expectations = MovedExpectations()
        self._expectations.at(self._freedoms, self._nu, lambda: self._there)
        self.labels = [
            Label(capture.id, capture.kind, block.statistic, block.stage, at)
            for block, at in self._taken.described()
        ]
        self._base = self.mean

    @property
    def real(self) -> NDArray[np.float64]:
        return self._there.real

    @property
    def sigma(self) -> NDArray[np.float64]:
        return self._floor

    @property
    def _simulations(self) -> SimulatedStatistics:
        return self._there.simulations

    @property
    def left_out(self) -> list[str]:
        return self._taken.left_out

    def nuisances(self, effects: Sequence[PlacedEffect]) -> dict[str, Any]:
        if not self._freedoms:
            return {}
        return stated(self._freedoms, self._marginal.most_likely(self._difference(effects)))

    # residuals --------------------------------------------------------------------------------------------

    def residual(self, effects: Sequence[PlacedEffect], draws: int = 1) -> NDArray[np.float64]:
        """See `Evidence`. Hypotheses share their noise, so that they differ by their effects alone."""
        return self._marginal.whitened(self._difference(effects, draws))

    def _difference(self, effects: Sequence[PlacedEffect], draws: int = 1) -> NDArray[np.float64]:
        """(K,) real less expected where the nuisances stand now [noise floor]."""
        expected = self._base
        if effects and not self._simulations.leaves_untouched(effects):
            changes = [self.simulated(effects, draw) - self._base_draw(draw) for draw in range(draws)]
            expected = self._base + np.mean(changes, axis=0)
        return np.asarray((self.real - expected) / self.sigma)

    @cached_property
    def null_replicates(self) -> NDArray[np.float64]:
        """See `Evidence`; nuisances are drawn from their priors."""
        return self._replicates(self._draws, self.mean, np.ones_like(self.sigma))

    def replicate_residuals(self, effects: Sequence[PlacedEffect]) -> ReplicateResiduals:
        """See `Evidence`: where an effect takes detail away, noise is larger in proportion."""
        if not effects or self._simulations.leaves_untouched(effects):
            return ReplicateResiduals(self.residual(effects), self.null_replicates, np.ones_like(self.sigma))
        draws = np.stack([self.simulated(effects, draw) for draw in range(N_REPLICATES)])
        scale = np.maximum(self._sigma(draws) / self.sigma, 1.0)
        mean = draws.mean(axis=0)
        z = (self.real - mean) / (self.sigma * scale)
        return ReplicateResiduals(
            self._marginal.whitened(z, scale), self._replicates(draws, mean, scale), scale
        )

    def _replicates(
        self, draws: NDArray[np.float64], mean: NDArray[np.float64], scale: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """(B, K) each draw against the others, as the real frames stand against all."""
        others = len(draws) / (len(draws) - 1)
        rng = generator(self._seed, "gap", self.capture.id, "nuisances")
        nuisances = rng.standard_normal((len(draws), len(self._freedoms)))
        z = (draws - mean) * others / (self.sigma * scale)
        return self._marginal.spread(z, nuisances, scale)

    def _sigma(self, draws: NDArray[np.float64]) -> NDArray[np.float64]:
        spread = self._taken.steadied(draws.std(axis=0, ddof=1))
        return np.asarray(np.sqrt(SPREAD_OF_ONE * spread**2 + self._luck + self._taken.margin**2))

    # nuisances --------------------------------------------------------------------------------------------

    def renuisanced(self, effects: Sequence[PlacedEffect]) -> ImageEvidence:
        """See `PictureEvidence`.

        Where there are no effects yet, pose begins where the pictures themselves align best.
        """
        if not self._freedoms:
            return self
        found = self
        if not effects and not self._nu.any():
            found = self._better_of(self._moved_to(registered(self.capture, self._freedoms)), effects)
        for _ in range(2):
            nu = found._marginal.most_likely(found._difference(effects))
            nearer = found._better_of(found._moved_to(nu), effects)
            if nearer is found:
                return found
            found = nearer
        return found

    def _moved_to(self, nu: NDArray[np.float64]) -> ImageEvidence:
        followed = [freedom.is_followed and freedom.share == 1 for freedom in self._freedoms]
        nu = np.where(followed, np.clip(nu, -FARTHEST, FARTHEST), 0.0)
        if np.abs(nu).max() < NEARBY:
            nu = np.zeros_like(nu)
        if np.abs(nu - self._nu).max() < NEARBY:
            return self
        return self._at(nu)

    def agreeing(self, shares: Mapping[str, float]) -> ImageEvidence:
        """See `PictureEvidence`.

        What was taken for a nuisance of each capture then is a gap of all.
        """
        if not shares or not any(freedom.name in shares for freedom in self._freedoms):
            return self
        nearer = copy(self)
        nearer._freedoms = tuple(f.within(shares[f.name]) if f.name in shares else f for f in self._freedoms)
        return nearer._at(np.where([f.name in shares for f in self._freedoms], 0.0, self._nu))

    def pose(self, effects: Sequence[PlacedEffect]) -> dict[str, float] | None:
        names = [freedom.name for freedom in self._freedoms]
        if POSE_TERMS[0] not in names:
            return None
        likely = self._marginal.most_likely(self._difference(effects))
        return {term: float(likely[names.index(term)]) for term in POSE_TERMS}

    def _at(self, nu: NDArray[np.float64]) -> ImageEvidence:
        moved = copy(self)
        for name in ("_marginal", "null_replicates"):
            moved.__dict__.pop(name, None)
        moved._nu = nu
        moved._there = there = self._expectations.at(self._freedoms, nu, lambda: self._expecting(nu))
        moved._base = self.mean + (there.base_draws[:_BASE_DRAWS] - self._draws[:_BASE_DRAWS]).mean(axis=0)
        return moved

    def _expecting(self, nu: NDArray[np.float64]) -> MovedExpectation:
        there = self._simulations.expecting(disturbed(self.capture, self._freedoms, nu))
        draws = np.stack([there.of((), draw) for draw in range(_BASE_DRAWS)])
        return MovedExpectation(there, there.real(), draws)

    def _better_of(self, moved: ImageEvidence, effects: Sequence[PlacedEffect]) -> ImageEvidence:
        if moved is self:
            return self
        least = 1.0 if effects else BETTER
        before, after = (
            _cost(each._difference(effects)) + float(each._nu @ each._nu) for each in (self, moved)
        )
        return moved if after < least * before else self

    @cached_property
    def _marginal(self) -> Marginal:
        return self._there.marginal(self._freedoms, self._simulated_marginal)

    def _simulated_marginal(self) -> Marginal:
        """Derivatives of the numbers by the nuisances, by simulations with the noise of the first draw."""
        here = self._base_draw(0) if self._freedoms else self._base
        share = self._simulations.noise_share
        directions = []
        for k, freedom in enumerate(self._freedoms):
            if freedom.is_followed:
                nearby = self._nu.copy()
                step = (_DIFFERENCE if nearby[k] <= 0 else -_DIFFERENCE) / freedom.share
                nearby[k] += step
                other = disturbed(self.capture, self._freedoms, nearby)
                change = (self._simulations.simulated(other, (), 0, share) - here) / step
            else:
                change = self._change_with_noise(freedom.sigma)
            directions.append(np.nan_to_num(change / self.sigma))
        columns = np.stack(directions, axis=1) if directions else np.zeros((len(self.sigma), 0))
        return Marginal(columns, self._nu)

    def _change_with_noise(self, share: float) -> NDArray[np.float64]:
        """(K,) how simulated numbers move against real ones if the expectation holds noise nobody stated."""
        changes = []
        for draw in range(_BASE_DRAWS):
            here = self._simulations.expectation
            simulated = self._simulations.simulated(here, (), draw, share) - self._base_draw(draw)
            changes.append(simulated - (self._simulations.real(share, draw) - self.real))
        return np.asarray(np.mean(changes, axis=0))

    # simulations ------------------------------------------------------------------------------------------

    def simulated(self, effects: Sequence[PlacedEffect], draw: int = 0) -> NDArray[np.float64]:
        """(K,) the statistics a simulation with these effects gives, with the noise of a draw."""
        return self._simulations.of(effects, draw)

    def _base_draw(self, draw: int) -> NDArray[np.float64]:
        known = self._there.base_draws
        return known[draw] if draw < len(known) else self.simulated((), draw)


def _variance_with_noise(simulations: SimulatedStatistics) -> NDArray[np.float64]:
    """(K,) variance of the numbers as the stated noise of the expectation might have fallen otherwise.

    All simulations are of one expectation, so that their spread does not show it.
    """
    if not simulations.noise_share:
        return np.zeros(int(simulations.taken.kept.sum()))
    found = [simulations.with_noise_anew(draw) for draw in range(_LUCK_DRAWS)]
    return np.nan_to_num(np.var(found, axis=0, ddof=1))


def _cost(z: NDArray[np.float64]) -> float:
    """Sum of squares in which wild numbers count by their logarithm."""
    return float(np.sum(np.log1p(z**2)))
