"""Digital images by the electron model of EMVA 1288: photons, electrons, full well, system gain."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Camera, CandidateFailed, Exposure, Fault, Rig, Settings, UserError, setting
from tacos_framework.camera import gain_factor, luminance
from tacos_plugins.sensors.electrons import Spectrum, count_electrons, photons_per_luminance, system_gain

NEEDED: Mapping[str, str] = {
    "quantum_efficiency": "electrons per photon",
    "full_well_e": "electrons a photosite holds",
    "read_noise_e": "noise without light, in electrons",
    "dark_current_e_s": "electrons per second without light",
}
"""Figures of a photosite that the model needs: the columns of a catalog, and the settings that stand in."""


@dataclass(frozen=True)
class Photosite:
    """All that the model needs to know of a camera's photosites; see `NEEDED` for the units."""

    quantum_efficiency: float
    full_well_e: float
    read_noise_e: float
    dark_current_e_s: float


class Emva:
    """A linear camera in electrons, with a full well, quantum efficiency, dark current and read noise.

    What the catalog knows of an image sensor is used; what it does not know, the settings must supply, for
    all sensors alike. A candidate whose sensor is known by neither fails, and says what is missing.

    The gain is that of the camera itself: at 0 dB the full well just fills the range of the files, unless
    `system_gain_dn_per_e` says otherwise. So here, unlike in `sensor.affine-noise`, brightness depends on the
    image sensor: a larger photosite collects more light, and has a larger well to fill.

    Averaging b x b photosites into one simulated pixel (`Camera.binning`) divides the variance by b^2.
    Effects of the stage pixel act on the signal that light makes; the dark signal joins it when electrons
    are counted.

    Source: `tacos_plugins.sensors.electrons`, which states the equations.

    >>> known = {"full_well_e": 1e4, "read_noise_e": 2.5}  # as of a catalog
    >>> sensor = Emva(Emva.Config(quantum_efficiency=0.6, dark_current_e_s=5.0, **known))
    >>> camera = Camera("camera", 640, 480, pixel_um=3.45, focal_length_mm=4.0)
    >>> wall_cd_m2 = 0.8 * 20 / np.pi  # reflectance 0.8 at 20 lux
    >>> round(wall_cd_m2 * sensor.electrons_per_luminance(camera, Exposure(0.030, f_number=2.0)))
    2331
    """

    class Config(Settings):
        quantum_efficiency: float | None = setting(
            None,
            help="Electrons per photon of the spectrum, filter and fill factor included, where the catalog "
            "does not know.",
            gt=0,
            le=1,
        )
        full_well_e: float | None = setting(
            None, help="Electrons a photosite holds, where the catalog does not know.", unit="e-", gt=0
        )
        read_noise_e: float | None = setting(
            None,
            help="Standard deviation of the noise without light, where the catalog does not know.",
            unit="e-",
            ge=0,
        )
        dark_current_e_s: float | None = setting(
            None,
            help="Electrons per second without light, where the catalog does not know.",
            unit="e-/s",
            ge=0,
        )
        channels: Literal["rgb", "mono", "by-part"] = setting(
            "rgb",
            help="Colour images, or luminance in one channel; by-part as the image sensor is, in colour "
            "where that is not known.",
        )
        channel_response: tuple[float, float, float] = setting(
            (1.0, 1.0, 1.0), help="Quantum efficiency of R, G and B over quantum_efficiency."
        )
        spectrum: Spectrum = setting("daylight", help="The light whose photons a lux stands for.")
        system_gain_dn_per_e: float | None = setting(
            None,
            help="Digital numbers per electron at 0 dB; by default the full well fills the range.",
            unit="DN/e-",
            gt=0,
        )
        bit_depth: int = setting(12, help="Bits per sample of the images.", unit="bit", ge=1, le=16)
        black_level_dn: float = setting(
            0.0, help="Pedestal in the images, which keeps noise around black from clipping.", unit="DN", ge=0
        )

    use: ClassVar[str] = "sensor.emva"
    """Its name in messages."""

    def __init__(self, config: Config) -> None:
        self.config = config
        faults = []
        if (config.black_level_dn or 0) >= self.white_level_dn:
            faults.append(
                Fault(
                    self.use,
                    f"black_level_dn is {config.black_level_dn}",
                    f"below the white level, {self.white_level_dn} DN at {config.bit_depth} bit",
                    "Lower black_level_dn or raise bit_depth.",
                )
            )
        if not all(response > 0 for response in config.channel_response or ()):
            faults.append(
                Fault(self.use, f"channel_response is {config.channel_response}", "three numbers above 0")
            )
        if faults:
            raise UserError(faults)

    @property
    def black_level_dn(self) -> float:
        return self.config.black_level_dn

    @property
    def white_level_dn(self) -> float:
        return 2**self.config.bit_depth - 1

    def expect(
        self, light_cd_m2: NDArray[np.float32], *, camera: Camera, exposure: Exposure
    ) -> NDArray[np.float32]:
        """See `tacos_framework.contracts.Sensor.expect`; without the dark signal, which joins in `draw`.

        Raises `CandidateFailed` when neither the catalog nor the settings know all that the model needs of an
        image sensor.
        """
        if self.is_mono(camera):
            light_cd_m2 = luminance(light_cd_m2)[..., None].astype(np.float32)
        else:
            light_cd_m2 = light_cd_m2 * np.array(self.channel_response(camera), np.float32)
        gain = self.sample_gain_dn_per_e(camera, exposure)
        samples = light_cd_m2 * np.asarray(gain * self.electrons_per_luminance(camera, exposure), np.float32)
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
        """See `tacos_framework.contracts.Sensor.moments`; the mean has the dark signal."""
        site, gain = (
            self.photosite(camera),
            np.asarray(self.sample_gain_dn_per_e(camera, exposure), np.float32),
        )
        dark_e = np.float32(site.dark_current_e_s * exposure.time_s)
        electrons = np.maximum((samples_dn - np.float32(self.black_level_dn)) / gain + dark_e, 0)
        variance_e2 = np.float32(photon_scale) * electrons + np.float32(
            self.read_noise_e(camera, exposure) ** 2
        )
        averaged = np.asarray(self.photosites(camera), np.float32)
        return samples_dn + gain * dark_e, gain**2 * variance_e2 / averaged

    def draw(
        self,
        samples_dn: NDArray[np.float32],
        *,
        camera: Camera,
        exposure: Exposure,
        rng: np.random.Generator,
        photon_scale: float = 1.0,
    ) -> NDArray[np.float32]:
        site, gain = self.photosite(camera), self.sample_gain_dn_per_e(camera, exposure)
        above_black = samples_dn - np.float32(self.black_level_dn)
        electrons = count_electrons(
            above_black / gain + site.dark_current_e_s * exposure.time_s,
            full_well_e=site.full_well_e,
            read_noise_e=self.read_noise_e(camera, exposure),
            rng=rng,
            photosites=self.photosites(camera),
            photon_scale=photon_scale,
        )
        return np.asarray(
            electrons * np.asarray(gain, np.float32) + np.float32(self.black_level_dn), np.float32
        )

    def is_mono(self, camera: Camera) -> bool:
        """True if a camera's images have one channel."""
        if self.config.channels == "by-part":
            return camera.colour == "mono"
        return self.config.channels == "mono"

    def channel_response(self, camera: Camera) -> tuple[float, float, float]:
        """Light that makes electrons in R, G and B, over that behind `quantum_efficiency` alone [1]."""
        return self.config.channel_response

    def sample_gain_dn_per_e(self, camera: Camera, exposure: Exposure) -> float | NDArray[np.float64]:
        """System gain of each channel; an array where they differ [DN/e-]."""
        return self.gain_dn_per_e(camera, exposure)

    def photosites(self, camera: Camera) -> float | NDArray[np.float64]:
        """Number of photosites averaged into a sample; an array where it differs by channel [1]."""
        return camera.binning**2

    def dn_per_electron(self, camera: Camera, exposure: Exposure) -> float | None:
        """System gain K [DN/e-]."""
        return self.gain_dn_per_e(camera, exposure)

    def lacks(self, rig: Rig) -> str | None:
        """Unknown figures of a rig's image sensors, in a sentence; None where all is known."""
        for camera in rig.cameras:
            try:
                self.photosite(camera)
            except CandidateFailed as error:
                return str(error)
        return None

    def photosite(self, camera: Camera) -> Photosite:
        """Known figures of a camera's photosites: by the catalog, else by the settings.

        Raises `CandidateFailed` when something is known by neither; says what, for which image sensor.
        """
        known = {name: self._known(camera, name) for name in NEEDED}
        missing = [f"{name} ({NEEDED[name]})" for name, value in known.items() if value is None]
        if missing:
            sensor = camera.electrons.sensor or f"of camera {camera.name!r}"
            raise CandidateFailed(
                f"sensor.emva does not know {', '.join(missing)} of the image sensor {sensor}: the catalog "
                "leaves it out, and so do the settings of sensor.emva"
            )
        return Photosite(**{name: value for name, value in known.items() if value is not None})

    def read_noise_e(self, camera: Camera, exposure: Exposure) -> float:
        """Read noise of a photosite, the same at any gain [e-]."""
        return self.photosite(camera).read_noise_e

    def origins(self, camera: Camera) -> Mapping[str, str]:
        """Origin of each figure of a camera's photosites; see `SensorBase.origins`."""
        known = {name: getattr(camera.electrons, name) is not None for name in NEEDED}
        return {name: "catalog" if stated else "settings" for name, stated in known.items()}

    def gain_dn_per_e(self, camera: Camera, exposure: Exposure) -> float:
        """System gain K of a camera [DN/e-]."""
        if self.config.system_gain_dn_per_e is not None:
            return self.config.system_gain_dn_per_e * gain_factor(exposure.gain_db)
        range_dn = self.white_level_dn - self.black_level_dn
        return system_gain(self.photosite(camera).full_well_e, range_dn, exposure.gain_db)

    def electrons_per_luminance(self, camera: Camera, exposure: Exposure) -> float:
        """Electrons that one cd/m2 makes in a photosite, for a channel response of 1 [e- / (cd/m2)]."""
        photons = photons_per_luminance(
            time_s=exposure.time_s,
            f_number=exposure.f_number,
            pixel_um=camera.pixel_um,
            spectrum=self.config.spectrum,
        )
        return self.photosite(camera).quantum_efficiency * photons

    def _known(self, camera: Camera, name: str) -> float | None:
        of_catalog: float | None = getattr(camera.electrons, name)
        of_settings: float | None = getattr(self.config, name)
        return of_settings if of_catalog is None else of_catalog
