"""A capture with its expectation moved by nuisances, worked out once for each.

A search comes back to nuisances it has been at: those that were settled on are tried again beside no effect,
and go back to nothing where all captures agree on them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tacos_gap.evidence.simulated_statistics import SimulatedStatistics
from tacos_gap.nuisances import Freedom, Marginal

_KEPT = 4
"""Nuisances of a capture that are remembered, the last: each takes some copies of a frame."""


@dataclass(frozen=True, eq=False)
class MovedExpectation:
    """A capture with its expectation at some nuisances."""

    simulations: SimulatedStatistics
    real: NDArray[np.float64]  # (K,) the statistics of its real frames against the expectation
    base_draws: NDArray[np.float64]  # (B, K) those of simulations without effects, draw by draw
    _marginals: dict[tuple[float, ...], Marginal] = field(default_factory=dict, repr=False)

    def marginal(self, freedoms: Sequence[Freedom], make: Callable[[], Marginal]) -> Marginal:
        """Derivatives of the numbers by nuisances of these priors; made where they are not known."""
        sigmas = tuple(freedom.sigma for freedom in freedoms)
        if sigmas not in self._marginals:
            self._marginals[sigmas] = make()
        return self._marginals[sigmas]


class MovedExpectations:
    """The expectations that a capture was last looked at with, by their nuisances."""

    def __init__(self) -> None:
        self._known: dict[tuple[float, ...], MovedExpectation] = {}

    def at(
        self,
        freedoms: Sequence[Freedom],
        nu: NDArray[np.float64],
        make: Callable[[], MovedExpectation],
    ) -> MovedExpectation:
        """The one at (F,) nuisances in standard deviations of their priors; made where it is not known."""
        values = tuple(float(n * freedom.sigma) for n, freedom in zip(nu, freedoms, strict=True))
        found = self._known.pop(values, None) or make()
        self._known[values] = found  # the last now
        if len(self._known) > _KEPT:
            del self._known[next(iter(self._known))]
        return found
