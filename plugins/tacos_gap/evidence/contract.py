"""Contract of every kind of evidence: a capture with expected values, or the views of a board."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from tacos_framework.formation import PlacedEffect

N_NULL_REPLICATES = 16
"""Null replicates: simulations of each capture that its noise floor is made of."""


@dataclass(frozen=True)
class Label:
    """Meaning of one number of the evidence."""

    capture: str
    kind: str
    statistic: str
    stage: str
    at: Mapping[str, Any]


@dataclass(frozen=True, eq=False)
class ReplicateResiduals:
    """Residuals against simulated replicates of a hypothesis, in units of its own noise floor."""

    z: NDArray[np.float64]  # (K,) residuals [noise floor]
    replicates: NDArray[np.float64]  # (B, K) the hypothesis against itself [noise floor]
    scale: NDArray[np.float64]  # (K,) this noise floor over the simulator's own, at least 1


class Evidence(Protocol):
    """Evidence of one or several captures on a hypothesis."""

    @property
    def labels(self) -> Sequence[Label]: ...

    @property
    def null_replicates(self) -> NDArray[np.float64]:
        """(B, K) the numbers when the simulator stands against itself."""
        ...

    def residual(self, effects: Sequence[PlacedEffect], draws: int = 1) -> NDArray[np.float64]:
        """(K,) real less the mean of so many simulations with these effects, in units of the noise floor."""
        ...

    def replicate_residuals(self, effects: Sequence[PlacedEffect]) -> ReplicateResiduals:
        """Residuals and replicates when these effects are part of the simulator."""
        ...
