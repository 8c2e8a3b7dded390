"""Digital images by electrons: noise before and after the gain, stated priors for unpublished figures."""

from __future__ import annotations

import math
from collections.abc import Mapping

from tacos_framework import Camera, Exposure, Rig, setting
from tacos_framework.camera import gain_factor
from tacos_plugins.sensors.emva import NEEDED, Emva
from tacos_plugins.sensors.photosite_prior import assumed, assumed_from

AFTER_GAIN = "read_noise_share_after_gain"


class CameraSensor(Emva):
    """The electron model for sensors of which only some figures are published.

    Two things differ from `sensor.emva`. Read noise lies before and after the gain, so that in electrons it
    falls with the gain G:

        r(G)^2 = r^2 ((1 - s) + s / G^2)

    with r the read noise at 0 dB and s the share of its variance that arises after the gain. And a figure
    that neither the catalog nor the settings know is drawn from a prior over known sensors, once for each
    image sensor; `origins` says which figures are stated and which assumed.

    Run a study with several values of `assumptions` to see how far its answer hangs on what is not published.

    References
    ----------
    `tacos_plugins.sensors.electrons` (the model), `tacos_plugins.sensors.photosite_prior` (the priors). The
    recipe `noise_over_gain` holds read noise over gain against real cameras.

    Examples
    --------
    >>> sensor = CameraSensor(CameraSensor.Config())
    >>> camera = Camera("camera", 640, 480, pixel_um=1.55, focal_length_mm=3.6)
    >>> [round(sensor.read_noise_e(camera, Exposure(gain_db=gain_db)), 2) for gain_db in (0, 12, 24)]
    [2.46, 0.73, 0.44]
    """

    class Config(Emva.Config):
        """Settings of the sensor."""

        read_noise_share_after_gain: float | None = setting(
            None,
            help="Share of the read noise's variance at 0 dB that arises after the gain; by default that of "
            "the prior.",
            ge=0,
            le=1,
        )
        assumptions: int = setting(
            0,
            help="Which draw of the priors stands for unpublished figures: 0 is their middle, 1, 2, ... are "
            "draws.",
            ge=0,
        )

    config: Config

    def lacks(self, rig: Rig) -> str | None:
        """Nothing: what is not known is assumed."""
        return None

    def read_noise_e(self, camera: Camera, exposure: Exposure) -> float:
        """Read noise of a photosite at a gain [e-]."""
        share = self._known(camera, AFTER_GAIN)
        gain = gain_factor(exposure.gain_db)
        return self.photosite(camera).read_noise_e * math.sqrt((1 - share) + share / gain**2)

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
        return found

    def _known(self, camera: Camera, name: str) -> float:
        of_catalog: float | None = getattr(camera.electrons, name, None)
        of_settings: float | None = getattr(self.config, name)
        for value in (of_catalog, of_settings):
            if value is not None:
                return value
        return assumed(
            name, sensor=camera.electrons.sensor, pixel_um=camera.pixel_um, draw=self.config.assumptions
        )
