"""A sensor without settings, to see effects with."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tacos_framework.contracts.sensor import Samples
from tacos_framework.values import Camera, Exposure


class LinearSensor:
    """30 DN per cd/m2 in 8 bits above a pedestal of 16 DN; noise of photons (10 electrons per DN) and of 1 DN
    without light.
    """

    black_level_dn = 16.0
    white_level_dn = 255.0

    def expect(self, light_cd_m2: NDArray[np.float32], *, camera: Camera, exposure: Exposure) -> Samples:
        return light_cd_m2 * np.float32(30) + np.float32(self.black_level_dn)

    def moments(
        self, samples_dn: Samples, *, camera: Camera, exposure: Exposure, photon_scale: float = 1.0
    ) -> tuple[Samples, Samples]:
        """See `tacos_framework.contracts.Sensor.moments`."""
        signal = np.maximum(samples_dn - np.float32(self.black_level_dn), 0)
        photosites = camera.binning**2
        return samples_dn, np.float32(0.1 * photon_scale / photosites) * signal + np.float32(1 / photosites)

    def draw(
        self,
        samples_dn: Samples,
        *,
        camera: Camera,
        exposure: Exposure,
        rng: np.random.Generator,
        photon_scale: float = 1.0,
    ) -> Samples:
        _, variance = self.moments(samples_dn, camera=camera, exposure=exposure, photon_scale=photon_scale)
        noise: Samples = np.sqrt(variance) * rng.standard_normal(samples_dn.shape, np.float32)
        return samples_dn + noise

    def dn_per_electron(self, camera: Camera, exposure: Exposure) -> float:
        """System gain K [DN/e-]."""
        return 0.1
