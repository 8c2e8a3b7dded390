"""Effects of the sensor and its readout."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from tacos_validation.blind.generators.camera import IdealShot, Image
from tacos_validation.blind.generators.injected_effect import InjectedEffect


@dataclass(frozen=True)
class InjectedConversionGainError(InjectedEffect):
    """Fewer or more electrons behind a digital number."""

    name: ClassVar[str] = "conversion-gain-error"
    scale: float = 1.0

    @property
    def photon_factor(self) -> float:
        return self.scale


@dataclass(frozen=True)
class InjectedPrnu(InjectedEffect):
    """Pixels that respond more or less than others."""

    name: ClassVar[str] = "prnu"
    order: ClassVar[int] = 0
    sigma: float = 0.0

    def charge(self, mean: Image, shot: IdealShot, sensor: np.random.Generator) -> Image:
        return mean * np.maximum(sensor.normal(1.0, self.sigma, size=mean.shape), 0)


@dataclass(frozen=True)
class InjectedDarkCurrent(InjectedEffect):
    """Charge that gathers in the dark, fast in a few pixels."""

    name: ClassVar[str] = "dark-current"
    order: ClassVar[int] = 1
    rate_dn_s: float = 0.0
    hot_share: float = 0.0

    def charge(self, mean: Image, shot: IdealShot, sensor: np.random.Generator) -> Image:
        """Add rate times time; hot pixels a hundred times and more."""
        hot = sensor.random(mean.shape) < self.hot_share
        rate = np.where(hot, self.rate_dn_s + sensor.gamma(1.0, 300.0, size=mean.shape), self.rate_dn_s)
        return mean + rate * shot.exposure_ms * 1e-3


@dataclass(frozen=True)
class InjectedDsnu(InjectedEffect):
    """Pixels and columns with offsets of their own."""

    name: ClassVar[str] = "dsnu"
    order: ClassVar[int] = 2
    sigma_dn: float = 0.0
    column_sigma_dn: float = 0.0

    def charge(self, mean: Image, shot: IdealShot, sensor: np.random.Generator) -> Image:
        pixels = sensor.normal(0.0, self.sigma_dn, size=mean.shape)
        columns = sensor.normal(0.0, self.column_sigma_dn, size=(1, mean.shape[1], 1))
        return mean + pixels + columns


@dataclass(frozen=True)
class InjectedDefectLines(InjectedEffect):
    """A few rows and columns that stand off from the others, always the same ones."""

    name: ClassVar[str] = "defect-lines"
    order: ClassVar[int] = 3
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


@dataclass(frozen=True)
class InjectedCrosstalk(InjectedEffect):
    """Neighbours that share their charge after it was counted."""

    name: ClassVar[str] = "crosstalk"
    order: ClassVar[int] = 0
    share: float = 0.0

    def samples(self, samples: Image, shot: IdealShot, rng: np.random.Generator) -> Image:
        height, width = samples.shape[:2]
        wide = np.pad(samples, ((1, 1), (1, 1), (0, 0)), mode="edge")
        around = sum(wide[i : i + height, j : j + width] for i in range(3) for j in range(3)) - samples
        return np.asarray((1 - 8 * self.share) * samples + self.share * around)


@dataclass(frozen=True)
class InjectedSaturation(InjectedEffect):
    """Pixels full below full scale."""

    name: ClassVar[str] = "saturation"
    order: ClassVar[int] = 1
    level_dn: float = 255.0

    def samples(self, samples: Image, shot: IdealShot, rng: np.random.Generator) -> Image:
        return np.where(samples > self.level_dn, self.level_dn, samples)


@dataclass(frozen=True)
class InjectedNonlinearity(InjectedEffect):
    """An amplifier that bends."""

    name: ClassVar[str] = "nonlinearity"
    order: ClassVar[int] = 2
    a2: float = 0.0
    a3: float = 0.0

    def samples(self, samples: Image, shot: IdealShot, rng: np.random.Generator) -> Image:
        camera = shot.camera
        response = np.polynomial.Polynomial([0.0, 1.0, self.a2, self.a3])
        return camera.black_dn + camera.range_dn * np.asarray(
            response((samples - camera.black_dn) / camera.range_dn)
        )


@dataclass(frozen=True)
class InjectedReadNoise(InjectedEffect):
    """Noise added to every sample."""

    name: ClassVar[str] = "read-noise"
    order: ClassVar[int] = 3
    sigma_dn: float = 0.0

    def samples(self, samples: Image, shot: IdealShot, rng: np.random.Generator) -> Image:
        return samples + rng.normal(0.0, self.sigma_dn, size=samples.shape)


@dataclass(frozen=True)
class InjectedRowNoise(InjectedEffect):
    """Rows and columns that jump from frame to frame."""

    name: ClassVar[str] = "row-noise"
    order: ClassVar[int] = 4
    sigma_dn: float = 0.0
    column_sigma_dn: float = 0.0

    def samples(self, samples: Image, shot: IdealShot, rng: np.random.Generator) -> Image:
        height, width = samples.shape[:2]
        rows = rng.normal(0.0, self.sigma_dn, size=(height, 1, 1))
        return samples + rows + rng.normal(0.0, self.column_sigma_dn, size=(1, width, 1))


@dataclass(frozen=True)
class InjectedBlackLevelError(InjectedEffect):
    """A pedestal other than believed."""

    name: ClassVar[str] = "black-level"
    order: ClassVar[int] = 5
    offset_dn: float = 0.0

    def samples(self, samples: Image, shot: IdealShot, rng: np.random.Generator) -> Image:
        return samples + self.offset_dn


@dataclass(frozen=True)
class InjectedQuantisation(InjectedEffect):
    """A converter with coarse steps, or one that rounds down."""

    name: ClassVar[str] = "quantisation"
    order: ClassVar[int] = 6
    step_dn: float = 1.0
    rounding: str = "nearest"

    def samples(self, samples: Image, shot: IdealShot, rng: np.random.Generator) -> Image:
        half = 0.5 if self.rounding == "nearest" else 0.0
        return np.floor(samples / self.step_dn + half) * self.step_dn
