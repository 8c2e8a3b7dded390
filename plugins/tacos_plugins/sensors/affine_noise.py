"""Digital images with photon and thermal noise (paper eq. 1)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Camera, Exposure, Fault, Settings, UserError, setting
from tacos_framework.camera import exposure_per_luminance, gain_factor, luminance
from tacos_plugins.sensors.calibration import Calibration, load_calibration
from tacos_plugins.sensors.noise import add_noise, gain_ratio


class NoiseLevels(NamedTuple):
    """Variance of one simulated pixel, per channel, in the units of the file."""

    photon_dn: NDArray[np.float32]
    thermal_dn2: NDArray[np.float32]


class AffineNoise:
    """The paper's sensor: a linear response with Gaussian noise of affine variance, per channel.

    The scenario's gain is that of the *calibrated* photosite. A camera with larger photosites is run at a
    gain lower in proportion to their area, as in the paper, so that one scene gives equal intensities on
    every sensor and cameras differ in noise alone. The expected signal therefore does not depend on the
    pitch:

        I = R (G / G0) H,    H = pi L t / (4 N^2)

    with R the responsivity at the calibrated gain G0 and H the focal-plane exposure. Averaging b x b
    photosites into one simulated pixel (`Camera.binning`) divides the variance by b^2. A calibration of one
    channel stands for a monochrome sensor, whose images are the luminance of the scene.

    Rounding to whole digital numbers, which the framework does last, adds 1/12 DN^2, as in a real converter.

    >>> sensor = AffineNoise(AffineNoise.Config(calibration="flea3_imx172"))
    >>> white_wall_cd_m2 = 0.8 * 20 / np.pi  # reflectance 0.8 at 20 lux
    >>> round(white_wall_cd_m2 * sensor.dn_per_luminance(Exposure(0.030, f_number=2.0, gain_db=5.0)))
    200
    """

    class Config(Settings):
        calibration: str | Calibration = setting(
            "flea3_imx172",
            help="Noise calibration: a name in the catalogs, a file, or its numbers.",
            is_path=True,
        )
        responsivity_dn_per_lux_s: float | None = setting(
            None,
            help=(
                "Signal per focal-plane exposure at the calibrated gain and bit depth; by default the "
                "calibration's. It sets the brightness of the images and is chosen, not measured, as the "
                "paper tunes its ISO by hand: a white wall at 20 lux, f/2, 30 ms and 5 dB gives about 200 of "
                "255."
            ),
            unit="DN/(lux s)",
            gt=0,
        )
        bit_depth: int | None = setting(
            None, help="Bits per sample of the images; by default the calibration's.", unit="bit", ge=1, le=16
        )
        black_level_dn: float = setting(
            0.0, help="Pedestal in the images, which keeps noise around black from clipping.", unit="DN", ge=0
        )

    def __init__(self, config: Config) -> None:
        self.config = config
        given = config.calibration
        self.calibration = load_calibration(given) if isinstance(given, str) else given
        self.bit_depth = config.bit_depth or self.calibration.bit_depth
        if config.black_level_dn >= self.white_level_dn:
            raise UserError(
                Fault(
                    "sensor.affine-noise",
                    f"black_level_dn is {config.black_level_dn}",
                    f"below the white level, {self.white_level_dn} DN at {self.bit_depth} bit",
                    "Lower black_level_dn or raise bit_depth.",
                )
            )

    @property
    def black_level_dn(self) -> float:
        return self.config.black_level_dn

    @property
    def white_level_dn(self) -> float:
        return 2**self.bit_depth - 1

    def expect(
        self, light_cd_m2: NDArray[np.float32], *, camera: Camera, exposure: Exposure
    ) -> NDArray[np.float32]:
        """See `tacos_framework.contracts.Sensor.expect`; a calibration of one channel gives luminance."""
        if len(self.calibration.photon_dn) == 1:
            light_cd_m2 = luminance(light_cd_m2)[..., None].astype(np.float32)
        samples = light_cd_m2 * np.float32(self.dn_per_luminance(exposure))
        if self.black_level_dn:
            samples += np.float32(self.black_level_dn)
        return samples

    def moments(
        self,
        samples_dn: NDArray[np.float32],
        *,
        camera: Camera,
        exposure: Exposure,
        photon_scale: float = 1.0,
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """See `tacos_framework.contracts.Sensor.moments` (eq. 1)."""
        levels = self.noise_levels(camera, exposure.gain_db)
        signal = np.maximum(samples_dn - np.float32(self.black_level_dn), 0)
        return samples_dn, levels.photon_dn * np.float32(photon_scale) * signal + levels.thermal_dn2

    def draw(
        self,
        samples_dn: NDArray[np.float32],
        *,
        camera: Camera,
        exposure: Exposure,
        rng: np.random.Generator,
        photon_scale: float = 1.0,
    ) -> NDArray[np.float32]:
        levels = self.noise_levels(camera, exposure.gain_db)
        noisy = np.empty(samples_dn.shape, np.float32)
        add_noise(
            samples_dn,
            noisy,
            black_level_dn=self.black_level_dn,
            photon_dn=levels.photon_dn * np.float32(photon_scale),
            thermal_dn2=levels.thermal_dn2,
            rng=rng,
        )
        return noisy

    def dn_per_electron(self, camera: Camera, exposure: Exposure) -> float | None:
        """System gain K of a photosite [DN/e-]: the slope of the photon noise, that of green in colour.

        The variance of n electrons is n, so that K^2 n over K n is what the calibration calls s_p.
        """
        photon = self.noise_levels(replace(camera, binning=1.0), exposure.gain_db).photon_dn
        return float(photon[len(photon) // 2]) or None

    def origins(self, camera: Camera) -> Mapping[str, str]:
        """One calibration stands for every image sensor; see `SensorBase.origins`."""
        calibration = self.calibration
        scaled = "" if camera.pixel_um == calibration.pixel_um else ", scaled by the area of the photosites"
        return {"noise": f"assumed as measured on {calibration.title}{scaled}"}

    def dn_per_luminance(self, exposure: Exposure) -> float:
        """Signal above black that one cd/m2 makes [DN / (cd/m2)]."""
        responsivity = self.config.responsivity_dn_per_lux_s or self.calibration.responsivity_dn_per_lux_s
        gain = gain_factor(exposure.gain_db - self.calibration.gain_db)
        lux_s = exposure_per_luminance(exposure.time_s, exposure.f_number)
        return responsivity * self._file_scale * gain * lux_s

    def noise_levels(self, camera: Camera, gain_db: float) -> NoiseLevels:
        """Noise levels by the calibration for a camera's photosites, its binning, and the scenario's gain."""
        ratio = gain_ratio(
            gain_db,
            camera.pixel_um,
            calibrated_gain_db=self.calibration.gain_db,
            calibrated_pixel_um=self.calibration.pixel_um,
        )
        photosites = camera.binning**2
        photon = np.array(self.calibration.photon_dn) * ratio * self._file_scale / photosites
        thermal = np.array(self.calibration.thermal_dn2) * ratio**2 * self._file_scale**2 / photosites
        return NoiseLevels(photon.astype(np.float32), thermal.astype(np.float32))

    @property
    def _file_scale(self) -> float:
        """Digital numbers of the images per digital number of the calibration [1]."""
        return 2.0 ** (self.bit_depth - self.calibration.bit_depth)
