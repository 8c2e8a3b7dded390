"""Disturbances of one capture, and its pictures under them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tacos_validation.blind.generators.camera import IdealCamera, IdealShot, Image, Look
from tacos_validation.blind.generators.injected_effect import InjectedEffect
from tacos_validation.blind.generators.light_effects import InjectedDefocus


@dataclass(frozen=True)
class CaptureNuisance:
    """Disturbances of one capture, or of all captures of a group."""

    shift_px: tuple[float, float] = (0.0, 0.0)
    turn_deg: float = 0.0
    gain: float = 1.0  # a factor of the light
    slope: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Relative, over the width, the height and the diagonals."""
    level_uncertainty: float = 0.0
    expected_frames: int = 0  # noisy frames behind the expectation; 0 for a noiseless one
    defocus_px: float = 0.0  # radius of a disc [px]
    file_quality: int | None = None

    def real(self, shot: IdealShot) -> IdealShot:
        look = shot.look
        if shot.has_pose and (any(self.shift_px) or self.turn_deg):
            look = _OffPlace(look, shot.camera, self)
        if self.gain != 1 or any(self.slope):
            look = _OffLamp(look, shot.camera, self)
        return replace(shot, look=look)

    @property
    def effects(self) -> tuple[InjectedEffect, ...]:
        return (InjectedDefocus(self.defocus_px),) if self.defocus_px else ()

    @property
    def declared(self) -> dict[str, Any]:
        """Keys of ``captures.yaml`` that own up to it."""
        uncertain = {"level_uncertainty": self.level_uncertainty} if self.level_uncertainty else {}
        return {**uncertain, **({"simulated_frames": self.expected_frames} if self.expected_frames else {})}


AS_BELIEVED = CaptureNuisance()
"""A capture in which nothing is off."""


@dataclass(frozen=True, eq=False)
class _OffPlace:
    """A look, seen from beside the place where it is believed to be seen from."""

    look: Look
    camera: IdealCamera
    off: CaptureNuisance

    def __call__(self, x: Image, y: Image, channel: int) -> Image:
        cx, cy = self.camera.centre_px
        turned = np.exp(1j * np.radians(self.off.turn_deg)) * ((x - cx) + 1j * (y - cy))
        return self.look(
            cx + turned.real + self.off.shift_px[0], cy + turned.imag + self.off.shift_px[1], channel
        )


@dataclass(frozen=True, eq=False)
class _OffLamp:
    look: Look
    camera: IdealCamera
    off: CaptureNuisance

    def __call__(self, x: Image, y: Image, channel: int) -> Image:
        cx, cy = self.camera.centre_px
        u, v = (x - cx) / self.camera.width_px, (y - cy) / self.camera.height_px
        slope_x, slope_y, saddle = self.off.slope
        uneven = 1 + slope_x * u + slope_y * v + saddle * 4 * u * v
        return self.look(x, y, channel) * self.off.gain * uneven
