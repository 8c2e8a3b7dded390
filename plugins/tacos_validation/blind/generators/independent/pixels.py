"""Pixels and converters by other makers: what each does that a formula for all pixels leaves out."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from scipy import signal, special

from tacos_validation.blind.generators.camera import IdealShot, Image
from tacos_validation.blind.generators.independent.amplitude import SingleAmplitudeEffect


class AvalancheGain(SingleAmplitudeEffect, name="conversion-gain-error", place=-1):
    """Electrons multiplied by chance, as in an electron-multiplying sensor: more noise at the same mean.

    Source: Basden, Haniff and Mackay 2003, "Photon counting strategies with low-light-level CCDs", MNRAS 345:
    gamma.
    """

    def samples(self, samples: Image, shot: IdealShot, rng: np.random.Generator) -> Image:
        """Replace the signal by a gamma variable of the same mean."""
        camera = shot.camera
        scale = camera.photon_dn * self.amplitude
        signal_dn = samples - camera.black_dn
        multiplied = rng.gamma(np.maximum(signal_dn, 1e-6) / scale, scale)
        return camera.black_dn + np.where(signal_dn > 0, multiplied, signal_dn)


class UnevenFullWells(SingleAmplitudeEffect, name="saturation", place=1):
    """Wells that are full at a level of each pixel's own."""

    spread: ClassVar[float] = 0.004

    def codes(self, codes: Image, shot: IdealShot, sensor: np.random.Generator) -> Image:
        camera = shot.camera
        wells = (1 - self.amplitude) * camera.range_dn * sensor.normal(1.0, self.spread, size=codes.shape)
        return np.minimum(codes, camera.black_dn + wells)


class UnevenDarkCurrent(SingleAmplitudeEffect, name="dark-current", place=1):
    """Dark current that spreads lognormally over pixels, some of which are hot.

    Source: Widenhorn et al. 2002, "Temperature dependence of dark current in a CCD", Proc. SPIE 4669.
    """

    def charge(self, mean: Image, shot: IdealShot, sensor: np.random.Generator) -> Image:
        rates = self.amplitude * sensor.lognormal(-0.5 * 0.3**2, 0.3, size=mean.shape)
        hot = sensor.random(mean.shape) < 1e-4
        rates = np.where(hot, rates + 100 * sensor.pareto(1.5, size=mean.shape), rates)
        return mean + rates * shot.exposure_ms * 1e-3

    @property
    def parameters(self) -> dict[str, Any]:
        return {"rate_dn_s": self.amplitude}


class HeavyTailedOffsets(SingleAmplitudeEffect, name="dsnu", place=2):
    """Offsets by Student's t with five degrees of freedom: more pixels far out than a Gaussian has."""

    def charge(self, mean: Image, shot: IdealShot, sensor: np.random.Generator) -> Image:
        return mean + self.amplitude * sensor.standard_t(5, size=mean.shape) / np.sqrt(5 / 3)

    @property
    def parameters(self) -> dict[str, Any]:
        return {"sigma_dn": self.amplitude}


class ChargeDiffusion(SingleAmplitudeEffect, name="crosstalk"):
    """Charge that wanders, less the farther; the amplitude goes to each of the four nearest neighbours."""

    def samples(self, samples: Image, shot: IdealShot, rng: np.random.Generator) -> Image:
        y, x = np.mgrid[-2:3, -2:3]
        square = x**2 + y**2
        kernel = np.where(square > 0, self.amplitude * 0.5 ** np.maximum(square - 1.0, 0), 0)
        kernel[2, 2] = 1 - kernel.sum()
        padded = np.pad(samples, ((2, 2), (2, 2), (0, 0)), mode="reflect")
        return np.asarray(signal.fftconvolve(padded, kernel[..., None], mode="valid"))


class UnevenCodes(SingleAmplitudeEffect, name="quantisation", place=6):
    """A converter some of whose codes are never given out, and others stand for more than their share."""

    def codes(self, codes: Image, shot: IdealShot, sensor: np.random.Generator) -> Image:
        """By a table: steps of about the amplitude, whose bounds are a little off."""
        white = int(shot.camera.white_dn)
        step = max(2, round(self.amplitude))
        bounds = np.arange(step / 2, white, step)
        bounds = bounds + 0.15 * step * sensor.uniform(-1, 1, size=bounds.shape)
        table = np.minimum(step * np.searchsorted(bounds, np.arange(white + 1)), white)
        return np.asarray(table[codes.astype(int)], np.float64)


class ClampedPedestal(SingleAmplitudeEffect, name="black-level", place=5):
    """A pedestal that a control loop holds: it wanders a little, and even rows differ from odd ones."""

    def samples(self, samples: Image, shot: IdealShot, rng: np.random.Generator) -> Image:
        rows = 0.02 * self.amplitude * (np.arange(samples.shape[0]) % 2 - 0.5)
        drift = 0.02 * self.amplitude * rng.standard_normal()
        return samples + self.amplitude + drift + rows[:, None, None]

    @property
    def parameters(self) -> dict[str, Any]:
        return {"offset_dn": self.amplitude}


class BlockReadout(SingleAmplitudeEffect, name="rolling-shutter", place=4):
    """A shutter that reads four rows at a time."""

    rows: ClassVar[int] = 4

    def rays(self, x: Image, y: Image, channel: int, shot: IdealShot, row: Image) -> tuple[Image, Image]:
        later_s = self.rows * np.floor(row / self.rows) * self.amplitude * 1e-6
        return x - shot.velocity_px_s[0] * later_s, y - shot.velocity_px_s[1] * later_s

    @property
    def parameters(self) -> dict[str, Any]:
        return {"row_time_us": self.amplitude}


class ErfShading(SingleAmplitudeEffect, name="lens-shading-correction", place=10):
    """Corners made brighter by a table for a lens whose light falls off as an error function."""

    def codes(self, codes: Image, shot: IdealShot, sensor: np.random.Generator) -> Image:
        r = np.sqrt(shot.camera.squared_radius())[..., None]
        rise = self.amplitude * (1 + special.erf((r - 0.75) / 0.4)) / 2
        rise = rise - self.amplitude * (1 + special.erf(-0.75 / 0.4)) / 2
        black = shot.camera.black_dn
        return np.asarray(black + (codes - black) * (1 + rise))
