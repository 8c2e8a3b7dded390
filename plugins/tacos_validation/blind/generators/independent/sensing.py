"""Sensors by other makers: responses and noise of other shapes."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy import signal

from tacos_validation.blind.generators.camera import IdealShot, Image
from tacos_validation.blind.generators.independent.amplitude import SingleAmplitudeEffect


class SoftFullWell(SingleAmplitudeEffect, name="nonlinearity", place=2):
    """A response that bends like an exponential."""

    def samples(self, samples: Image, shot: IdealShot, rng: np.random.Generator) -> Image:
        """(1 - exp(-a y)) / a."""
        camera = shot.camera
        y = (samples - camera.black_dn) / camera.range_dn
        return camera.black_dn + camera.range_dn * -np.expm1(-self.amplitude * y) / self.amplitude


class TelegraphNoise(SingleAmplitudeEffect, name="read-noise", place=3):
    """Read noise of a logistic shape, with pixels that jump between levels."""

    def samples(self, samples: Image, shot: IdealShot, rng: np.random.Generator) -> Image:
        jumps = 4 * self.amplitude * rng.integers(-1, 2, samples.shape) * (rng.random(samples.shape) < 0.005)
        scale = self.amplitude * np.sqrt(3) / np.pi
        return samples + rng.logistic(0.0, scale, size=samples.shape) + jumps


class DriftingRows(SingleAmplitudeEffect, name="row-noise", place=4):
    """Row offsets that wander."""

    def samples(self, samples: Image, shot: IdealShot, rng: np.random.Generator) -> Image:
        drawn = np.asarray(rng.normal(size=samples.shape[0]))
        offsets = signal.lfilter(np.array([np.sqrt(1 - 0.4**2)]), np.array([1.0, -0.4]), drawn)
        return samples + self.amplitude * offsets[:, None, None]

    @property
    def parameters(self) -> dict[str, Any]:
        return {"sigma_dn": self.amplitude}


class LognormalPixels(SingleAmplitudeEffect, name="prnu"):
    """Responses that spread lognormally."""

    def charge(self, mean: Image, shot: IdealShot, sensor: np.random.Generator) -> Image:
        return mean * sensor.lognormal(-(self.amplitude**2) / 2, self.amplitude, size=mean.shape)

    @property
    def parameters(self) -> dict[str, Any]:
        """Standard deviation, of a lognormal as narrow as this its own parameter."""
        return {"sigma": float(np.sqrt(np.expm1(self.amplitude**2)))}
