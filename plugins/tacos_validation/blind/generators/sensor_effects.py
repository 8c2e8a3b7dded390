"""Effects of the sensor and its readout."""

from __future__ import annotations

from typing import Any

import numpy as np

from tacos_validation.blind.generators.camera import IdealShot, Image
from tacos_validation.blind.generators.injected_effect import InjectedEffect


class InjectedConversionGainError(InjectedEffect, name="conversion-gain-error"):
    """Fewer or more electrons behind a digital number."""

    scale: float = 1.0

    @property
    def photon_factor(self) -> float:
        return self.scale


class InjectedConversionGainMode(InjectedEffect, name="conversion-gain-mode"):
    """Other noise in the dark from a gain on."""

    noise_scale: float = 1.0
    from_db: float = 0.0

    def dark_factor(self, shot: IdealShot) -> float:
        return self.noise_scale if shot.gain_db >= self.from_db else 1.0

    @property
    def parameters(self) -> dict[str, Any]:
        """The scale; captures tell of the gain only that it lies between two of theirs."""
        return {"noise_scale": self.noise_scale}


class InjectedPrnu(InjectedEffect, name="prnu"):
    """Pixels that respond more or less than others."""

    sigma: float = 0.0

    def charge(self, mean: Image, shot: IdealShot, sensor: np.random.Generator) -> Image:
        return mean * np.maximum(sensor.normal(1.0, self.sigma, size=mean.shape), 0)


class InjectedDarkCurrent(InjectedEffect, name="dark-current", place=1):
    """Charge that gathers in the dark, fast in a few pixels."""

    rate_dn_s: float = 0.0
    hot_share: float = 0.0

    def charge(self, mean: Image, shot: IdealShot, sensor: np.random.Generator) -> Image:
        """Add rate times time; hot pixels a hundred times and more."""
        hot = sensor.random(mean.shape) < self.hot_share
        rate = np.where(hot, self.rate_dn_s + sensor.gamma(1.0, 300.0, size=mean.shape), self.rate_dn_s)
        return mean + rate * shot.exposure_ms * 1e-3


class InjectedDsnu(InjectedEffect, name="dsnu", place=2):
    """Pixels and columns with offsets of their own."""

    sigma_dn: float = 0.0
    column_sigma_dn: float = 0.0

    def charge(self, mean: Image, shot: IdealShot, sensor: np.random.Generator) -> Image:
        pixels = sensor.normal(0.0, self.sigma_dn, size=mean.shape)
        columns = sensor.normal(0.0, self.column_sigma_dn, size=(1, mean.shape[1], 1))
        return mean + pixels + columns


class InjectedDefectLines(InjectedEffect, name="defect-lines", place=3):
    """A few rows and columns that stand off from the others, always the same ones."""

    offset_dn: float = 0.0
    columns: int = 2
    rows: int = 1

    def charge(self, mean: Image, shot: IdealShot, sensor: np.random.Generator) -> Image:
        height, width = mean.shape[:2]
        bad = np.zeros((height, width), bool)
        bad[:, sensor.choice(width, self.columns, replace=False)] = True
        bad[sensor.choice(height, self.rows, replace=False)] = True
        return mean + self.offset_dn * bad[..., None]

    @property
    def parameters(self) -> dict[str, Any]:
        """The offset; how many lines there are, the catalogue says as a share of an image's."""
        return {"offset_dn": self.offset_dn}


class InjectedCrosstalk(InjectedEffect, name="crosstalk"):
    """Neighbours that share their charge after it was counted."""

    share: float = 0.0

    def samples(self, samples: Image, shot: IdealShot, rng: np.random.Generator) -> Image:
        height, width = samples.shape[:2]
        wide = np.pad(samples, ((1, 1), (1, 1), (0, 0)), mode="edge")
        around = sum(wide[i : i + height, j : j + width] for i in range(3) for j in range(3)) - samples
        return np.asarray((1 - 8 * self.share) * samples + self.share * around)


class InjectedSaturation(InjectedEffect, name="saturation", place=1):
    """Pixels full below full scale."""

    level_dn: float = 255.0

    def samples(self, samples: Image, shot: IdealShot, rng: np.random.Generator) -> Image:
        return np.where(samples > self.level_dn, self.level_dn, samples)


class InjectedNonlinearity(InjectedEffect, name="nonlinearity", place=2):
    """An amplifier that bends."""

    a2: float = 0.0
    a3: float = 0.0

    def samples(self, samples: Image, shot: IdealShot, rng: np.random.Generator) -> Image:
        camera = shot.camera
        response = np.polynomial.Polynomial([0.0, 1.0, self.a2, self.a3])
        return camera.black_dn + camera.range_dn * np.asarray(
            response((samples - camera.black_dn) / camera.range_dn)
        )


class InjectedReadNoise(InjectedEffect, name="read-noise", place=3):
    """Noise added to every sample, before the gain and after it."""

    sigma_dn: float = 0.0  # at 0 dB
    after_gain_dn: float = 0.0

    def samples(self, samples: Image, shot: IdealShot, rng: np.random.Generator) -> Image:
        sigma_dn = np.hypot(self.sigma_dn * shot.gain, self.after_gain_dn)
        return samples + rng.normal(0.0, sigma_dn, size=samples.shape)

    @property
    def parameters(self) -> dict[str, Any]:
        return {name: value for name, value in vars(self).items() if value}


class InjectedRowNoise(InjectedEffect, name="row-noise", place=4):
    """Rows and columns that jump from frame to frame."""

    sigma_dn: float = 0.0
    column_sigma_dn: float = 0.0

    def samples(self, samples: Image, shot: IdealShot, rng: np.random.Generator) -> Image:
        height, width = samples.shape[:2]
        rows = rng.normal(0.0, self.sigma_dn, size=(height, 1, 1))
        return samples + rows + rng.normal(0.0, self.column_sigma_dn, size=(1, width, 1))


class InjectedBlackLevelError(InjectedEffect, name="black-level", place=5):
    """A pedestal other than believed."""

    offset_dn: float = 0.0

    def samples(self, samples: Image, shot: IdealShot, rng: np.random.Generator) -> Image:
        return samples + self.offset_dn


class InjectedQuantisation(InjectedEffect, name="quantisation", place=6):
    """A converter with coarse steps, or one that rounds down."""

    step_dn: float = 1.0
    rounding: str = "nearest"

    def samples(self, samples: Image, shot: IdealShot, rng: np.random.Generator) -> Image:
        half = 0.5 if self.rounding == "nearest" else 0.0
        return np.floor(samples / self.step_dn + half) * self.step_dn
