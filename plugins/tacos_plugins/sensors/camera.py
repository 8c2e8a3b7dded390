"""Digital images by electrons, mono or mosaic by the part, with stated priors for unpublished figures."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import replace
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Camera, Exposure, Rig, setting
from tacos_framework.camera import gain_factor
from tacos_plugins.sensors.emva import NEEDED, Emva, Photosite
from tacos_plugins.sensors.mosaic_noise import FILTERED, averaged_variances
from tacos_plugins.sensors.photosite_prior import Draw, assumed, assumed_from

AFTER_GAIN = "read_noise_share_after_gain"
COLOURS = ("red_over_green", "blue_over_green")
MIDDLE: Draw = (0,)
PEDESTAL = 1 / 16
"""Pedestal over full scale where it is not known: the median of the sensors of the catalogs that state it."""
STATED_AT_C = 25.0
"""Temperature that dark currents of catalogs are taken to hold at, as few say [deg C]."""


class CameraSensor(Emva):
    """The electron model for sensors of which only some figures are published.

    A figure that neither the catalog nor the settings know is drawn from a prior over known sensors, of each
    image sensor by itself; `origins` says which figures are stated and which assumed. A study draws anew
    in each scene, the same for all candidates with that part, so that what is not known scatters its scores.

    Read noise lies before and after the gain, so that in electrons it falls with the gain G:

        r(G)^2 = r^2 ((1 - s) + s / G^2) + q(G)^2 / 12

    with r the read noise at 0 dB, s the share of its variance that arises after the gain, and q a step of the
    part's converter, where its bits are known and fewer than those of the files. From
    `high_gain_from_db` on, r is that of a second conversion gain, and G counts from there.

    A part without filters gives one channel, by the light's luminance. Filters pass a third of the light on
    average, most to green and least to red; white balance amplifies red and blue, and their noise with them.
    Where blocks of b x b pixels of a mosaic are simulated as one, each colour has the noise
    that averaging its reconstructed pixels leaves; the mosaic itself is `effect.demosaic`, at b = 1.

    Dark current doubles every `dark_doubling_c` degrees (EMVA 1288, release 4.0).

    Source: `tacos_plugins.sensors.electrons` (the model), `tacos_plugins.sensors.photosite_prior` (the
    priors), `tacos_plugins.sensors.mosaic_noise` (filters). The recipe `noise_over_gain` holds read noise
    over gain against real cameras.

    >>> sensor = CameraSensor(CameraSensor.Config())
    >>> camera = Camera("camera", 640, 480, pixel_um=1.55, focal_length_mm=3.6)
    >>> [round(sensor.read_noise_e(camera, Exposure(gain_db=gain_db)), 2) for gain_db in (0, 12, 24)]
    [2.55, 0.76, 0.45]
    """

    class Config(Emva.Config):
        channels: Literal["rgb", "mono", "by-part"] = setting(
            "by-part",
            help="Colour images, or luminance in one channel; by-part as the image sensor is, in colour "
            "where that is not known.",
        )
        channel_response: tuple[float, float, float] | None = setting(  # type: ignore[assignment]
            None,
            help="Light that makes electrons behind the filters of R, G and B, of that which a photosite "
            "without gathers; by default a third on average, shared out as the catalog or the prior has it.",
        )
        black_level_dn: float | None = setting(  # type: ignore[assignment]
            None,
            help="Pedestal in the images, which keeps noise around black from clipping; by default that of "
            "the part, or a sixteenth of full scale where it is not known.",
            unit="DN",
            ge=0,
        )
        white_balance: bool = setting(
            True,
            help="Amplify red and blue until grey is grey, as cameras do; false leaves files in the colours "
            "of the filters.",
        )
        read_noise_share_after_gain: float | None = setting(
            None,
            help="Share of the read noise's variance at 0 dB that arises after the gain; by default that of "
            "the prior.",
            ge=0,
            le=1,
        )
        high_gain_from_db: float | None = setting(
            None,
            help="Gain from which on the higher of two conversion gains is used, where the catalog does not "
            "know; one conversion gain if neither says.",
            unit="dB",
        )
        high_gain_read_noise_e: float | None = setting(
            None, help="Read noise at that gain, where the catalog does not know.", unit="e-", ge=0
        )
        temperature_c: float = setting(
            STATED_AT_C, help="Temperature of the image sensor.", unit="deg C", ge=-100, le=150
        )
        dark_doubling_c: float = setting(
            8.0, help="Warming that doubles the dark current; 6 to 10 is usual.", unit="deg C", gt=0
        )
        assumptions: int | None = setting(
            None,
            help="Which draw of the priors stands for unpublished figures: 0 is their middle, 1, 2, ... are "
            "draws; by default a study draws them anew in each scene.",
            ge=0,
        )

    use: ClassVar[str] = "sensor.camera"
    config: Config
    _draw: Draw = MIDDLE
    _pedestal_dn: float | None = None

    @property
    def black_level_dn(self) -> float:
        """Pedestal of its files: as set, else that of the cameras it is `behind`, else 0 [DN]."""
        given = self.config.black_level_dn
        return (self._pedestal_dn or 0.0) if given is None else given

    def behind(self, cameras: Sequence[Camera]) -> CameraSensor:
        """The sensor with the pedestal of these cameras' part: of several parts the largest."""
        if self._pedestal_dn is not None:
            return self
        shares = (each.electrons.black_level_share for each in cameras)
        placed = copy(self)
        placed._pedestal_dn = float(
            round(self.white_level_dn * max(PEDESTAL if share is None else share for share in shares))
        )
        return placed

    def assuming(self, draw: Draw) -> CameraSensor:
        if self.config.assumptions is not None:
            return self
        drawn = copy(self)
        drawn._draw = draw
        return drawn

    @property
    def draw_of_priors(self) -> Draw:
        """The draw that stands for what is not published."""
        fixed = self.config.assumptions
        return self._draw if fixed is None else (fixed,)

    def lacks(self, rig: Rig) -> str | None:
        """Nothing: what is not known is assumed."""
        return None

    def photosite(self, camera: Camera) -> Photosite:
        """Known or assumed figures of a camera's photosites, at the sensor's temperature."""
        site = super().photosite(camera)
        warmer = 2 ** ((self.config.temperature_c - STATED_AT_C) / self.config.dark_doubling_c)
        return replace(site, dark_current_e_s=site.dark_current_e_s * warmer)

    def channel_response(self, camera: Camera) -> tuple[float, float, float]:
        """Light behind the filters of a mosaic, of which half is green, over that without."""
        if self.config.channel_response is not None:
            return self.config.channel_response
        red, blue = (self._figure(camera, name) for name in COLOURS)
        green = 4 * FILTERED / (red + 2 + blue)
        return red * green, green, blue * green

    def sample_gain_dn_per_e(self, camera: Camera, exposure: Exposure) -> float | NDArray[np.float64]:
        """System gain, of red and blue with their white balance."""
        gain = self.gain_dn_per_e(camera, exposure)
        if not self.config.white_balance or self.is_mono(camera):
            return gain
        response = np.array(self.channel_response(camera))
        return gain * response[1] / response

    def photosites(self, camera: Camera) -> float | NDArray[np.float64]:
        """Number of photosites averaged into a sample: of a mosaic, as many as have the noise it has."""
        if self.config.channels == "by-part" and camera.colour != "mono" and camera.simulated_binning > 1:
            return camera.sensor_binning**2 / np.array(averaged_variances(camera.simulated_binning))
        return camera.binning**2

    def read_noise_e(self, camera: Camera, exposure: Exposure) -> float:
        """Read noise of a photosite at a gain [e-]."""
        read_noise_e, gain_db = self.photosite(camera).read_noise_e, exposure.gain_db
        from_db = self._stated(camera, "high_gain_from_db")
        in_high_gain_e = self._stated(camera, "high_gain_read_noise_e")
        if from_db is not None and in_high_gain_e is not None and gain_db >= from_db:
            read_noise_e, gain_db = in_high_gain_e, gain_db - from_db
        share = self._known(camera, AFTER_GAIN)
        variance_e2 = read_noise_e**2 * ((1 - share) + share / gain_factor(gain_db) ** 2)
        return math.sqrt(variance_e2 + self._converter_step_e(camera, exposure) ** 2 / 12)

    def origins(self, camera: Camera) -> Mapping[str, str]:
        """Origin of each figure of a camera's photosites; see `SensorBase.origins`."""
        found = {}
        for figure in (*NEEDED, AFTER_GAIN):
            if getattr(camera.electrons, figure, None) is not None:
                found[figure] = "catalog"
            elif getattr(self.config, figure) is not None:
                found[figure] = "settings"
            else:
                found[figure] = assumed_from(figure)
        if self.config.black_level_dn is not None:
            found["black_level"] = "settings"
        elif camera.electrons.black_level_share is not None:
            found["black_level"] = "catalog"
        else:
            found["black_level"] = "assumed, a sixteenth of full scale"
        if not self.is_mono(camera) and self.config.channel_response is None:
            for figure in COLOURS:
                known = getattr(camera.electrons, figure) is not None
                found[figure] = "catalog" if known else assumed_from(figure)
        if self.config.channels == "by-part":
            found["colour"] = "assumed, as the catalog does not say" if camera.colour is None else "catalog"
        return found

    def _converter_step_e(self, camera: Camera, exposure: Exposure) -> float:
        """A step of the part's converter [e-]; 0 where files are as coarse, whose own rounding then shows."""
        bits = camera.electrons.converter_bits
        if bits is None or bits >= self.config.bit_depth:
            return 0.0
        range_dn = self.white_level_dn - self.black_level_dn
        return range_dn / (2**bits - 1) / self.gain_dn_per_e(camera, exposure)

    def _stated(self, camera: Camera, name: str) -> float | None:
        """A figure by the catalog, else by the settings."""
        of_catalog: float | None = getattr(camera.electrons, name, None)
        of_settings: float | None = getattr(self.config, name)
        return of_settings if of_catalog is None else of_catalog

    def _known(self, camera: Camera, name: str) -> float:
        stated = self._stated(camera, name)
        return self._figure(camera, name) if stated is None else stated

    def _figure(self, camera: Camera, name: str) -> float:
        """A figure by the catalog, else by its prior."""
        of_catalog: float | None = getattr(camera.electrons, name, None)
        if of_catalog is not None:
            return of_catalog
        sensor = camera.electrons.sensor
        return assumed(name, sensor=sensor, pixel_um=camera.pixel_um, draw=self.draw_of_priors)
