"""Contract of every kind of evidence: a capture with expected values, or the views of a board."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from tacos_framework.formation import PlacedEffect
from tacos_gap.captures import RealCapture

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


class PictureEvidence(ABC):
    """Evidence of one capture with expected values, in this process or in another."""

    capture: RealCapture
    labels: Sequence[Label]

    @property
    @abstractmethod
    def real(self) -> NDArray[np.float64]:
        """(K,) the statistics of the real frames."""

    @property
    @abstractmethod
    def sigma(self) -> NDArray[np.float64]:
        """(K,) one noise-floor unit, in the unit of each statistic."""

    @property
    @abstractmethod
    def null_replicates(self) -> NDArray[np.float64]:
        """See `Evidence`."""

    @property
    @abstractmethod
    def left_out(self) -> list[str]:
        """Names of statistics that some simulations gave no number of."""

    @abstractmethod
    def residual(self, effects: Sequence[PlacedEffect], draws: int = 1) -> NDArray[np.float64]:
        """See `Evidence`."""

    @abstractmethod
    def replicate_residuals(self, effects: Sequence[PlacedEffect]) -> ReplicateResiduals:
        """See `Evidence`."""

    @abstractmethod
    def nuisances(self, effects: Sequence[PlacedEffect]) -> dict[str, Any]:
        """Offsets of the expectation beside effects, as in ``diagnosis.json``; empty if there are none."""

    @abstractmethod
    def pose(self, effects: Sequence[PlacedEffect]) -> dict[str, float] | None:
        """Offset of its pose beside effects, by term [standard deviations]; None where it has none."""

    @abstractmethod
    def renuisanced(self, effects: Sequence[PlacedEffect]) -> PictureEvidence:
        """The evidence with nuisances estimated anew beside these effects; itself where they stay."""

    @abstractmethod
    def agreeing(self, shares: Mapping[str, float]) -> PictureEvidence:
        """The evidence where terms of pose are off by shares of their priors alone; itself where none is."""
