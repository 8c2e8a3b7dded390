"""The camera as the simulator believes it to be, and one picture-taking of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.float64]

PAD_PX = 24
"""Margin rendered around an image, so that blur at its rim finds light."""


@dataclass(frozen=True)
class IdealCamera:
    """A camera without effects."""

    width_px: int
    height_px: int
    focal_px: float
    channels: int  # 1 or 3
    black_dn: float = 16.0
    white_dn: float = 255.0
    photon_dn: float = 0.24  # digital numbers per electron, so also the variance per DN of signal [DN]
    thermal_dn2: float = 1.8  # variance in the dark [DN^2]
    pixel_um: float = 6.0

    @property
    def centre_px(self) -> tuple[float, float]:
        """Principal point (x, y) [px]."""
        return (self.width_px - 1) / 2, (self.height_px - 1) / 2

    @property
    def range_dn(self) -> float:
        return self.white_dn - self.black_dn

    def grid(self, pad: int = 0) -> tuple[Image, Image]:
        """x and y of all pixels, with a margin: two (H + 2 pad, W + 2 pad) arrays [px]."""
        y, x = np.mgrid[-pad : self.height_px + pad, -pad : self.width_px + pad]
        return x.astype(np.float64), y.astype(np.float64)

    def squared_radius(self, pad: int = 0) -> Image:
        """Squared distance from the principal point, 1 in the corner of the sensor (H + 2 pad, W + 2 pad)."""
        x, y = self.grid(pad)
        cx, cy = self.centre_px
        return ((x - cx) ** 2 + (y - cy) ** 2) / ((self.width_px**2 + self.height_px**2) / 4)


Look = Callable[[Image, Image, int], Image]
"""Light in directions given as pixels of the ideal camera: (x, y, channel) to DN above the pedestal."""


@dataclass(frozen=True)
class IdealShot:
    """One exposure of a view."""

    camera: IdealCamera
    look: Look  # what is before it, at the exposure of the shot
    exposure_ms: float
    velocity_px_s: tuple[float, float] = (0.0, 0.0)
    depth_m: float = 1.0
    gain_db: float = 0.0
    has_pose: bool = True  # whether the simulator claims to know the pose; of a board it does not

    @property
    def gain(self) -> float:
        """Factor on the digital numbers of the camera, and on its noise, by the gain [1]."""
        return float(10 ** (self.gain_db / 20))


def dark(x: Image, y: Image, channel: int) -> Image:
    return np.zeros_like(x)
