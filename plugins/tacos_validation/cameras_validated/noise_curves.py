"""Noise against intensity of a camera: in reality, and in its simulation before and after."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework.formation import EpisodeDraws, PlacedEffect
from tacos_gap.captures import RealCapture
from tacos_gap.simulation.formation import simulate
from tacos_plugins.noise_calibration.levels import Levels, measure_levels
from tacos_plugins.noise_calibration.photon_transfer import fit_affine

FRAMES = 2
"""Of each capture: a pair tells the variance, whatever the pattern on the sensor."""

KINDS = ("dark", "flat", "bracket", "chart", "scene")


@dataclass(frozen=True, eq=False)
class NoiseCurve:
    """Noise of one camera over its signal."""

    levels: Mapping[str, Levels]  # for each stack what was measured, level by level
    slope: Mapping[str, tuple[float, float, float] | None]
    """For each stack the slope of variance over signal with its 95 % interval; None where no line fits
    [DN]."""

    def off(self, stack: str) -> float:
        """Median of how far the simulated variance is from the real one at the same signal, relative [1]."""
        real, simulated = self.levels["real"], self.levels[stack]
        used = real.clipped <= 0.01
        at = np.interp(real.mean_dn[used], simulated.mean_dn, simulated.variance_dn2)
        return float(np.median(np.abs(at / np.maximum(real.variance_dn2[used], 1e-9) - 1)))

    def as_data(self) -> dict[str, Any]:
        stacks = {}
        for name, levels in self.levels.items():
            slope = self.slope[name]
            stacks[name] = {
                "photon_dn": None if slope is None else slope[0],
                "ci": None if slope is None else list(slope[1:]),
                "signal_dn": levels.mean_dn.round(3).tolist(),
                "variance_dn2": levels.variance_dn2.round(4).tolist(),
            }
        return {**stacks, "off": {name: self.off(name) for name in self.levels if name != "real"}}


def noise_curve(
    captures: Sequence[RealCapture], effects: Sequence[PlacedEffect], seed: int
) -> NoiseCurve | None:
    """Measure what a camera's captures tell; None where none was taken twice at one gain."""
    usable = [c for c in captures if c.kind in KINDS and c.frames >= FRAMES and c.expected_dn is not None]
    if not usable:
        return None
    gains = [c.context.gain_db for c in usable]
    common = max(set(gains), key=gains.count)
    usable = [c for c in usable if c.context.gain_db == common]
    white = float(usable[0].context.white_level_dn)
    stacks: dict[str, list[NDArray[np.float32]]] = {"real": [], "sim_before": [], "sim_after": []}
    for capture in usable:
        draws = EpisodeDraws(seed, ("noise", capture.id))
        stacks["real"].append(capture.real_dn[:FRAMES])
        stacks["sim_before"].append(simulate(capture, (), draws, frames=FRAMES))
        stacks["sim_after"].append(simulate(capture, effects, draws, frames=FRAMES))
    levels = {
        name: measure_levels([_green(frames) for frames in stack], white_level_dn=white)
        for name, stack in stacks.items()
    }
    black = float(usable[0].context.black_level_dn)
    return NoiseCurve(levels, {name: _slope(found, black) for name, found in levels.items()})


def _green(frames_dn: NDArray[np.float32]) -> NDArray[np.uint16]:
    """(N, H, W) of the middle channel; files hold whole numbers of at most 16 bits [DN]."""
    return frames_dn[..., frames_dn.shape[-1] // 2].astype(np.uint16)


def _slope(levels: Levels, black_level_dn: float) -> tuple[float, float, float] | None:
    try:
        line = fit_affine(levels, black_level_dn=black_level_dn)
    except ValueError:
        return None
    return line.photon_dn, *line.photon_ci
