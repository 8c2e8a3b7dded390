"""Captures turned into standardised differences between the real camera and a simulation of it.

The noise floor is the simulator's own: the same captures simulated many times over with other noise. What
differs by less than that, or by less than the equivalence margin of its statistic, is no gap.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from tacos_framework.contracts import LIGHT_STAGES
from tacos_framework.formation import EpisodeDraws, PlacedEffect
from tacos_framework.randomness import generator
from tacos_gap.captures import RealCapture
from tacos_gap.formation import lit_by, simulate
from tacos_gap.statistics import Sample, StatisticBlock, measure

N_NULL_REPLICATES = 16
"""Null replicates: simulations of each capture that its noise floor is made of."""

N_REPLICATES = 16
"""Simulated replicates that the noise floor of a hypothesis is made of."""

SPREAD_OF_ONE = 1.5
"""Variance of real less simulated over that of real alone: the simulated mean is not known exactly."""


@dataclass(frozen=True)
class Label:
    """What one number of the evidence is."""

    capture: str
    kind: str
    statistic: str
    stage: str
    at: Mapping[str, Any]


@dataclass(frozen=True, eq=False)
class ReplicateResiduals:
    """Residuals against simulated replicates of a hypothesis, in units of its own noise floor.

    Parameters
    ----------
    z
        (K,) residuals [noise floor].
    replicates
        (B, K) the hypothesis against itself [noise floor].
    scale
        (K,) this noise floor over the simulator's own, at least 1.
    """

    z: NDArray[np.float64]
    replicates: NDArray[np.float64]
    scale: NDArray[np.float64]


class Evidence(Protocol):
    """What one or several captures say of a hypothesis."""

    @property
    def labels(self) -> Sequence[Label]:
        """What each number is."""
        ...

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


class ImageEvidence:
    """Statistics of a capture with expected values.

    Parameters
    ----------
    capture
        The capture.
    seed
        Seeds the noise of the simulations.
    replicates
        Simulations the noise floor is made of.
    """

    def __init__(self, capture: RealCapture, seed: int, replicates: int = N_NULL_REPLICATES):
        assert capture.expected_dn is not None
        self.capture = capture
        self._seed = seed
        self._kept: dict[tuple[str, int], NDArray[np.float64]] = {}
        blocks = measure(Sample(capture, capture.real_dn, capture.expected_dn))
        self.labels = [
            Label(capture.id, capture.kind, block.statistic, block.stage, at)
            for block in blocks
            for at in block.at
        ]
        self.real = _values(blocks)
        draws = np.stack([self._simulated((), draw) for draw in range(replicates)])
        self._draws = draws
        self.mean = draws.mean(axis=0)
        self._blocks = blocks
        self._margin = np.concatenate([np.broadcast_to(b.margin, b.values.shape) for b in blocks])
        self.sigma = self._sigma(draws)
        self._level = self._level_direction()
        self.null_replicates = np.stack(
            [self._without_level((draw - self.mean) / self.sigma) for draw in draws]
        )

    def residual(self, effects: Sequence[PlacedEffect], draws: int = 1) -> NDArray[np.float64]:
        """See `Evidence`. Hypotheses share their noise, so that they differ by their effects alone."""
        expected = self.mean
        if effects and not self._untouched(effects):
            changes = [self._simulated(effects, draw) - self._draws[draw] for draw in range(draws)]
            expected = self.mean + np.mean(changes, axis=0)
        return self._without_level((self.real - expected) / self.sigma)

    def replicate_residuals(self, effects: Sequence[PlacedEffect]) -> ReplicateResiduals:
        """See `Evidence`: where an effect takes detail away, noise is larger in proportion."""
        if not effects or self._untouched(effects):
            return ReplicateResiduals(self.residual(effects), self.null_replicates, np.ones_like(self.sigma))
        draws = np.stack([self._simulated(effects, draw) for draw in range(N_REPLICATES)])
        sigma = np.maximum(self._sigma(draws), self.sigma)
        mean = draws.mean(axis=0)
        return ReplicateResiduals(
            self._without_level((self.real - mean) / sigma),
            np.stack([self._without_level((draw - mean) / sigma) for draw in draws]),
            sigma / self.sigma,
        )

    def _sigma(self, draws: NDArray[np.float64]) -> NDArray[np.float64]:
        spread = _steadied(draws.std(axis=0, ddof=1), self._blocks)
        return np.asarray(np.sqrt(SPREAD_OF_ONE * spread**2 + self._margin**2))

    def simulated(self, effects: Sequence[PlacedEffect]) -> NDArray[np.float64]:
        """(K,) the statistics a simulation with these effects gives, with the noise of the first draw."""
        return self._simulated(effects, 0)

    def _simulated(self, effects: Sequence[PlacedEffect], draw: int) -> NDArray[np.float64]:
        """(K,) statistics of a draw with these effects, simulated once for residuals and replicates alike."""
        key = repr([(effect.use, effect.config) for effect in effects]), draw
        if key not in self._kept:
            self._kept[key] = self._measured(effects, draw)
        return self._kept[key]

    def _measured(self, effects: Sequence[PlacedEffect], draw: int) -> NDArray[np.float64]:
        capture = self.capture
        frames = simulate(capture, effects, self._draws_of(draw))
        assert capture.expected_dn is not None
        expected = capture.expected_dn
        if capture.expected_frames:
            black = np.float32(capture.context.black_level_dn)
            spread = np.sqrt(capture.noise.variance_dn2(expected - black) / capture.expected_frames)
            rng = generator(self._seed, "gap", capture.id, draw, "expected")
            expected = expected + rng.standard_normal(expected.shape, dtype=np.float32) * spread
        return _values(measure(Sample(capture, frames, expected)))

    def _draws_of(self, draw: int) -> EpisodeDraws:
        return EpisodeDraws(self._seed, ("gap", self.capture.id, draw))

    def _untouched(self, effects: Sequence[PlacedEffect]) -> bool:
        """Whether effects on light leave this capture as it is: all of them do in the dark."""
        if any(effect.cls.stage not in LIGHT_STAGES for effect in effects):
            return False
        assert self.capture.expected_dn is not None
        light = self.capture.expected_dn - np.float32(self.capture.context.black_level_dn)
        if not light.any():
            return True
        if light.min() != light.max():
            return False
        frame = light[:1]
        draws = EpisodeDraws(self._seed, ("untouched",))
        return all(
            (changed := lit_by(self.capture, [effect], frame, draws)) is frame
            or np.allclose(changed, frame, rtol=1e-6)
            for effect in effects
        )

    def _level_direction(self) -> NDArray[np.float64] | None:
        """How the numbers move when the light is stronger by one `level_uncertainty`."""
        share = self.capture.level_uncertainty
        if not share:
            return None
        assert self.capture.expected_dn is not None
        black = np.float32(self.capture.context.black_level_dn)
        brighter = replace(
            self.capture, expected_dn=(self.capture.expected_dn - black) * np.float32(1 + share) + black
        )
        frames = simulate(brighter, (), self._draws_of(0))
        moved = _values(measure(Sample(self.capture, frames, self.capture.expected_dn)))
        return np.asarray((moved - self._draws[0]) / self.sigma)

    def _without_level(self, z: NDArray[np.float64]) -> NDArray[np.float64]:
        """Whiten by the uncertain level: along its direction d the variance is 1 + d.d rather than 1."""
        if self._level is None or not (size := float(self._level @ self._level)):
            return z
        along = float(self._level @ z) / size
        return z - self._level * along * (1 - 1 / np.sqrt(1 + size))


def _values(blocks: Sequence[StatisticBlock]) -> NDArray[np.float64]:
    return np.concatenate([block.values for block in blocks]) if blocks else np.zeros(0)


def _steadied(spread: NDArray[np.float64], blocks: Sequence[StatisticBlock]) -> NDArray[np.float64]:
    """Standard deviations from few draws, none far below the middle one of its block."""
    steady = []
    start = 0
    for block in blocks:
        part = spread[start : start + len(block.values)]
        start += len(part)
        steady.append(np.maximum(part, 0.6 * np.median(part)) if len(part) else part)
    return np.concatenate(steady) if steady else spread
