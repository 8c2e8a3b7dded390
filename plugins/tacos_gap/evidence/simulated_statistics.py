"""Statistics of simulated frames of one capture: what was simulated once is not simulated again.

Hypotheses share the noise of a draw, so that they differ by their effects alone. Where the effects leave
the very files that there are without them, nothing is measured again: most effects touch few captures.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tacos_framework import LIGHT_STAGES, generator
from tacos_framework.formation import EffectChain, EpisodeDraws, PlacedEffect
from tacos_gap.captures import RealCapture
from tacos_gap.nuisances import expectation_noise, with_noise_of_expectation
from tacos_gap.simulation.formation import lit_by, simulate
from tacos_gap.simulation.kept_light import KeptLight
from tacos_gap.statistics import Sample, StatisticBlock, measure
from tacos_gap.statistics.taken_statistics import TakenStatistics
from tacos_plugins.sensors.kept_numbers import KeptNumbers

_NUMBERS_BYTES = 1 << 25
"""Noise of a capture that is remembered at most, of the draw that hundreds of hypotheses share."""

_LIGHT_BYTES = 1 << 25
"""Light of a capture that is remembered at most."""

_GLIMPSE = 997  # every so manieth value is compared before all of them are


class SimulatedStatistics:
    """Simulates a capture and measures what comes out.

    - `expectation`: the same capture with what is expected of it now; `capture` itself, or one that nuisances
      have moved.
    - `taken`: which numbers are taken; all that are finite in the real frames by default.
    - `numbers`: remembers the noise of the first draw; by default nobody else's.
    """

    def __init__(
        self,
        capture: RealCapture,
        expectation: RealCapture,
        seed: int,
        taken: TakenStatistics | None = None,
        numbers: KeptNumbers | None = None,
    ):
        self.capture = capture
        self.expectation = expectation
        self._seed = seed
        self._numbers = numbers or KeptNumbers(_NUMBERS_BYTES)
        self._light = KeptLight(_LIGHT_BYTES)
        self._bears: dict[str, bool] = {}
        self._kept: dict[tuple[str, int], NDArray[np.float64]] = {}
        self._plain: tuple[NDArray[np.uint16], NDArray[np.float64]] | None = None
        self.taken = taken or TakenStatistics.of(self.real_blocks())

    def expecting(self, expectation: RealCapture) -> SimulatedStatistics:
        return SimulatedStatistics(self.capture, expectation, self._seed, self.taken, self._numbers)

    def taking(self, taken: TakenStatistics, kept: NDArray[np.bool_]) -> SimulatedStatistics:
        """Fewer numbers of the same simulations: (K,) those `kept` of what was taken."""
        fewer = SimulatedStatistics(self.capture, self.expectation, self._seed, taken, self._numbers)
        fewer._kept = {key: values[kept] for key, values in self._kept.items()}
        if self._plain is not None:
            fewer._plain = self._plain[0], self._plain[1][kept]
        return fewer

    @property
    def noise_share(self) -> float:
        """Variance of the noise that the expectation is stated to hold, over that of a frame."""
        return 1 / self.capture.expected_frames if self.capture.expected_frames else 0.0

    # simulated --------------------------------------------------------------------------------------------

    def of(self, effects: Sequence[PlacedEffect], draw: int) -> NDArray[np.float64]:
        """(K,) statistics of a draw with these effects, simulated once for residuals and replicates alike."""
        effects = self._bearing(effects)
        key = repr([(effect.use, effect.config) for effect in effects]), draw
        if key not in self._kept:
            self._kept[key] = self.simulated(self.expectation, effects, draw, self.noise_share)
        return self._kept[key]

    def simulated(
        self, of: RealCapture, effects: Sequence[PlacedEffect], draw: int, noise_share: float
    ) -> NDArray[np.float64]:
        """(K,) statistics of frames of `of`, against the expectation where it stands.

        - `of`: what is expected of the frames.
        - `draw`: number of the draw; the same draws give noise that is comparable.
        - `noise_share`: variance of the noise in the expectation, over that of a frame.
        """
        draws = EpisodeDraws(self._seed, ("gap", self.capture.id, draw))
        light = self._light if of is self.expectation else None
        frames = simulate(of, effects, draws, kept=None if draw else self._numbers, light=light)
        known = draw == 0 and of is self.expectation and noise_share == self.noise_share
        if known and effects and self._plain is not None and _are_equal(frames, self._plain[0]):
            return self._plain[1]
        expected = self._expected_dn
        rng = generator(self._seed, "gap", self.capture.id, draw, "expected")
        noise = expectation_noise(self.capture, rng, 2 * noise_share)
        expected = expected if noise is None else expected + noise
        values = self.taken.values(measure(Sample(self.capture, frames, expected)))
        if known and not effects:
            self._plain = frames.astype(np.uint16), values
        return values

    def _bearing(self, effects: Sequence[PlacedEffect]) -> list[PlacedEffect]:
        """Effects without those on light that leave this capture as it is.

        All do in the dark. An even field nothing moves or blurs until another effect makes it uneven.
        """
        idle = []
        placed = {(effect.use, effect.name): effect for effect in effects}
        chain = EffectChain.of(effects, self.capture.geometry, self.capture.context)
        for acting in chain.light:
            effect = placed[acting.use, acting.name]
            key = repr((effect.use, effect.config))
            if key not in self._bears:
                self._bears[key] = not self.leaves_untouched([effect])
            if self._bears[key]:
                break
            idle.append(effect)
        return [effect for effect in effects if effect not in idle]

    @property
    def _is_dark(self) -> bool:
        low, high = self._range_dn
        return low == high == self.capture.context.black_level_dn

    def leaves_untouched(self, effects: Sequence[PlacedEffect]) -> bool:
        """True if effects on light leave this capture as it is: all of them do in the dark."""
        if any(effect.cls.stage not in LIGHT_STAGES for effect in effects):
            return False
        if self._is_dark:
            return True
        low, high = self._range_dn
        if low != high:
            return False
        assert self.capture.expected_dn is not None
        frame = self.capture.expected_dn[:1] - np.float32(self.capture.context.black_level_dn)
        draws = EpisodeDraws(self._seed, ("untouched",))
        return all(_are_alike(lit_by(self.capture, [effect], frame, draws), frame) for effect in effects)

    @cached_property
    def _range_dn(self) -> tuple[float, float]:
        """Least and largest value that is expected [DN]."""
        assert self.capture.expected_dn is not None
        return float(self.capture.expected_dn.min()), float(self.capture.expected_dn.max())

    # real -------------------------------------------------------------------------------------------------

    def real_blocks(self, noise_share: float | None = None, draw: int = 0) -> list[StatisticBlock]:
        rng = generator(self._seed, "gap", self.capture.id, draw, "real")
        share = self.noise_share if noise_share is None else noise_share
        noisier = with_noise_of_expectation(self.capture, rng, share)
        return measure(Sample(self.capture, self.capture.real_dn, self._expected_dn, noisier))

    def real(self, noise_share: float | None = None, draw: int = 0) -> NDArray[np.float64]:
        return self.taken.values(self.real_blocks(noise_share, draw))

    def with_noise_anew(self, draw: int) -> NDArray[np.float64]:
        """(K,) statistics of the first draw as the noise of the expectation might have fallen otherwise."""
        rng = generator(self._seed, "gap", self.capture.id, draw, "luck")
        noise = expectation_noise(self.capture, rng, self.noise_share)
        assert noise is not None
        assert self.capture.expected_dn is not None
        other = replace(self.capture, expected_dn=self.capture.expected_dn + noise)
        return self.simulated(other, (), 0, self.noise_share)

    @property
    def _expected_dn(self) -> NDArray[np.float32]:
        assert self.expectation.expected_dn is not None
        return self.expectation.expected_dn


def _are_alike(changed: NDArray[np.float32], frame: NDArray[np.float32]) -> bool:
    """True if light is what it was but for rounding; a glimpse tells most that is not."""
    if changed is frame:
        return True
    return all(
        np.allclose(changed.reshape(-1)[::step], frame.reshape(-1)[::step], rtol=1e-6)
        for step in (_GLIMPSE, 1)
    )


def _are_equal(frames: NDArray[np.float32], files: NDArray[np.uint16]) -> bool:
    """True if simulated frames are the files; a glimpse tells most that are not."""
    glimpse = np.array_equal(frames.reshape(-1)[::_GLIMPSE], files.reshape(-1)[::_GLIMPSE])
    return glimpse and np.array_equal(frames, files)
