"""From frames to lines of variance over signal, with what speaks against them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tacos_framework import Fault, UserError
from tacos_plugins.noise_calibration.figure import Cloud
from tacos_plugins.noise_calibration.frame_files import FrameStack
from tacos_plugins.noise_calibration.levels import REACH_PX, Levels, measure_levels
from tacos_plugins.noise_calibration.photon_transfer import CLIPPED_SHARE, FINEST_DN2, AffineFit, fit_affine

FEW_FRAMES = 5
MOVING_EXCESS = 1.5
"""Edges that vary so much more than even parts have moved [1]."""
LEAST_BEND, CLEAR_BEND_Z = 0.05, 4.0
POOR_MISFIT = 4.0
MANY_OUTLIERS = 1e-4
STRONG_PATTERN = 0.5
"""Fixed pattern over noise, as standard deviations at the brightest levels, that deserves a warning [1]."""


@dataclass(frozen=True, eq=False)
class Measured:
    channel: str
    levels: Levels
    fit: AffineFit
    black_level_dn: float

    def cloud(self, photon_dn: float, thermal_dn2: float) -> Cloud:
        """The levels, and a line to hold against them; rounding is added to it."""
        signal = self.levels.mean_dn - self.black_level_dn
        line = photon_dn * np.maximum(signal, 0) + thermal_dn2 + 1 / 12
        return Cloud(
            self.channel, signal, self.levels.variance_dn2, self.levels.error_dn2, self.fit.used, line
        )

    def as_data(self) -> dict[str, Any]:
        fit = self.fit
        return {
            "photon_dn": {"value": fit.photon_dn, "ci": list(fit.photon_ci), "unit": "DN"},
            "thermal_dn2": {"value": fit.thermal_dn2, "ci": list(fit.thermal_ci), "unit": "DN^2"},
            "levels": int(fit.used.sum()),
            "misfit": fit.misfit,
            "bend": fit.bend,
            "fixed_pattern": pattern_share(self),
        }


def measure(
    stack: FrameStack, *, black_level_dn: float, white_level_dn: float, levels: int
) -> tuple[Measured, ...]:
    """Noise of every channel.

    Raises `UserError` when the frames are too few, the same, all saturated, of one brightness, or of a scene
    that moved.
    """
    if stack.frames < 2:
        raise UserError(
            Fault(
                stack.source,
                f"there is {stack.frames} frame",
                "at least 2 of the same scene with the same settings, better 10 or more",
                "Noise is what changes from frame to frame: take more of them.",
            )
        )
    found: list[Measured] = []
    faults: list[Fault] = []
    for channel, planes in stack.planes.items():
        steps = measure_levels(planes, white_level_dn=white_level_dn, levels=levels)
        try:
            fit = fit_affine(steps, black_level_dn=black_level_dn)
        except ValueError as error:
            same = all((frame == plane[0]).all() for plane in planes for frame in plane[1:])
            faults.append(_unusable(f"{stack.source}, channel {channel}", steps, str(error), same=same))
            continue
        if steps.edge_excess > MOVING_EXCESS:
            faults.append(
                Fault(
                    f"{stack.source}, channel {channel}",
                    f"where brightness changes, pixels vary {steps.edge_excess:.1f} times as elsewhere",
                    "a scene that stands still",
                    "Fix the camera and the target; take the frames without touching either.",
                )
            )
        found.append(Measured(channel, steps, fit, black_level_dn))
    if faults:
        raise UserError(faults)
    return tuple(found)


def _unusable(where: str, levels: Levels, reason: str, *, same: bool) -> Fault:
    """Why no line could be fitted, as far as it shows."""
    clipped = levels.clipped > CLIPPED_SHARE
    if clipped.size and clipped.mean() > 0.5:
        return Fault(
            where,
            f"{clipped.sum()} of {len(clipped)} levels reach 0 or the white level, where noise is cut off",
            "bars between black and white",
            "Change the exposure, or set bit_depth to that of the camera's samples.",
        )
    if same:
        return Fault(
            where,
            "all frames are the same: nothing changes from one to the next",
            "frames taken one after another",
            "Copies of one file hold no noise. Switch off denoising in the camera, or raise its gain.",
        )
    if not levels.pixels.any():
        return Fault(
            where,
            f"no level is left: every pixel lies within {REACH_PX} px of where brightness changes, or of the "
            "border of the frame",
            f"bars of {5 * REACH_PX} px or more, in frames larger than that",
            "Go nearer to the target, take fewer and wider bars, or crop less.",
        )
    fine = levels.variance_dn2 < FINEST_DN2
    if fine.mean() > 0.5:
        return Fault(
            where,
            f"the noise of {fine.sum()} of {len(fine)} levels is below half a digital number",
            "noise that spreads over whole numbers",
            "Raise the gain, or save more bits.",
        )
    return Fault(
        where,
        f"no line can be fitted: {reason}",
        "bars from black to white, each of some hundred pixels",
        "Photograph a target with at least five grey levels, in focus and evenly lit.",
    )


def pattern_share(measured: Measured) -> float:
    """Fixed pattern over the signal, at the brightest third of the levels [1]."""
    levels, used = measured.levels, measured.fit.used
    signal = (levels.mean_dn - measured.black_level_dn)[used]
    bright = signal >= signal.max() * 2 / 3
    pixels = levels.pixels[used][bright]
    fixed_dn2 = np.average(levels.fixed_dn2[used][bright], weights=pixels)
    return float(np.sqrt(fixed_dn2) / np.average(signal[bright], weights=pixels))


def doubts(stack: FrameStack, channels: tuple[Measured, ...]) -> list[str]:
    """Doubts for readers of the numbers, in sentences."""
    sentences = []
    if stack.frames < FEW_FRAMES:
        sentences.append(
            f"There are {stack.frames} frames; with 10 or more the intervals shrink and a scene that moves "
            "shows better."
        )
    for measured in channels:
        sentences += [f"{measured.channel}: {sentence}" for sentence in _doubts_of(measured)]
    return sentences


def _doubts_of(measured: Measured) -> list[str]:
    levels, fit = measured.levels, measured.fit
    found = []
    if abs(fit.bend) > LEAST_BEND and abs(fit.bend_z) > CLEAR_BEND_Z:
        found.append(
            f"the photon transfer bends ({fit.bend:+.0%} of the variance at the brightest level). The camera "
            "is not linear: look for a tone curve, a gamma, or saturation."
        )
    if fit.misfit > POOR_MISFIT:
        found.append(
            f"levels scatter about the line more than chance allows (reduced chi square {fit.misfit:.1f}); "
            "the intervals are widened accordingly."
        )
    if fit.saturation_dn is not None:
        found.append(
            f"photosites saturate at about {fit.saturation_dn:.0f} DN; brighter levels are left out."
        )
    if fit.thermal_dn2 < 0:
        found.append("the line meets black below zero variance; the calibration says 0.")
    bright = levels.variance_dn2[fit.used][-1]
    signal = levels.mean_dn[fit.used][-1] - measured.black_level_dn
    pattern = pattern_share(measured) * signal
    if pattern > STRONG_PATTERN * np.sqrt(bright):
        found.append(
            f"pixels differ from one another by {pattern / signal:.1%} of the signal, always alike. "
            "That fixed pattern is not part of the noise here; effect.prnu simulates it."
        )
    if levels.outliers > MANY_OUTLIERS * levels.pixels.sum():
        found.append(f"{levels.outliers} pixels jump and were left out.")
    return found
