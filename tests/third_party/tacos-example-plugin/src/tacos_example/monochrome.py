"""Electrons of a monochrome sensor with shot and read noise."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from tacos_framework import Camera, Exposure, Settings, setting
from tacos_framework.camera import exposure_per_luminance, luminance

Samples = NDArray[np.float32]


class MonochromeSensor:
    """Counts electrons of the luminance, without colour filters.

    A photosite of pitch p collects ``sensitivity p^2 H`` electrons from a focal-plane exposure H. Shot noise
    has their number as its variance, read noise a constant one; the full well is white at a gain of 0 dB.
    """

    class Config(Settings):
        sensitivity_e_per_lux_s_um2: float = setting(
            2500.0,
            help="Electrons for each lux second and um2; 2500 is a quantum efficiency of 0.6 in green light.",
            unit="e/(lux s um2)",
            gt=0,
        )
        full_well_e: float = setting(10_000.0, help="Electrons of a full photosite.", unit="e", gt=0)
        read_noise_e: float = setting(2.0, help="Standard deviation of read noise.", unit="e", ge=0)

    black_level_dn = 0.0
    white_level_dn = 255.0

    def __init__(self, config: Config) -> None:
        self.config = config

    def expect(self, light_cd_m2: Samples, *, camera: Camera, exposure: Exposure) -> Samples:
        """Signal of the luminance, one channel."""
        lux_s = luminance(light_cd_m2) * exposure_per_luminance(exposure.time_s, exposure.f_number)
        electrons = lux_s * self.config.sensitivity_e_per_lux_s_um2 * camera.pixel_um**2
        return (electrons * self.dn_per_electron(camera, exposure))[..., None].astype(np.float32)

    def moments(
        self, samples_dn: Samples, *, camera: Camera, exposure: Exposure, photon_scale: float = 1.0
    ) -> tuple[Samples, Samples]:
        """Shot noise and read noise; pixels that average photosites have less of them."""
        gain = np.float32(self.dn_per_electron(camera, exposure))
        shot_e2 = np.float32(photon_scale) * np.maximum(samples_dn / gain, 0)
        variance_e2 = shot_e2 + np.float32(self.config.read_noise_e**2)
        return samples_dn, gain**2 * variance_e2 / np.float32(camera.binning**2)

    def draw(
        self,
        samples_dn: Samples,
        *,
        camera: Camera,
        exposure: Exposure,
        rng: np.random.Generator,
        photon_scale: float = 1.0,
    ) -> Samples:
        """Samples with Gaussian noise of that variance."""
        _, variance = self.moments(samples_dn, camera=camera, exposure=exposure, photon_scale=photon_scale)
        return samples_dn + np.sqrt(variance) * rng.standard_normal(samples_dn.shape, dtype=np.float32)

    def dn_per_electron(self, camera: Camera, exposure: Exposure) -> float:
        """What an electron adds to a sample."""
        return self.white_level_dn / self.config.full_well_e * exposure.gain
