"""One camera on the agent."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from tacos_framework.settings import Settings, setting
from tacos_framework.values import Rig
from tacos_plugins.rigs.mounted_camera import (
    DERIVED_UNITS,
    SensorPart,
    derived_optics,
    image_coordinates,
    mounted_camera,
)


class MonocularRig:
    """One camera, ``camera``, straight above the agent's eye, pitched up or down.

    Examples
    --------
    >>> builder = MonocularRig(MonocularRig.Config(binning=4))
    >>> flea3 = {"width_px": 4000, "height_px": 3000, "pixel_um": 1.55}
    >>> variables = MonocularRig.Variables(focal_length_mm=3.6, sensor=flea3)
    >>> camera = builder.build(variables).cameras[0]
    >>> camera.width_px, camera.height_px, round(camera.hfov_deg, 2)
    (1000, 750, 81.46)
    """

    class Config(Settings):
        """Settings of the rig."""

        binning: float = setting(
            1.0,
            help="Simulate blocks of binning x binning photosites as one pixel, to run on a small machine.",
            ge=1,
        )
        height_above_eye_m: float = setting(
            0.0, help="Height of the optical centre above the agent's eye.", unit="m"
        )

    class Variables(Settings):
        """What a recipe may design or fix."""

        pitch_deg: float = setting(0.0, help="Tilt of the camera, positive is up.", unit="deg", ge=-90, le=90)
        focal_length_mm: float = setting(help="Focal length of the lens.", unit="mm", gt=0)
        sensor: SensorPart = setting(help="Image sensor: a row of a catalog, or its size and pitch.")

    derived_quantities: ClassVar[Mapping[str, str]] = DERIVED_UNITS

    def __init__(self, config: Config) -> None:
        self.config = config

    def build(self, variables: Variables) -> Rig:
        """The rig of these variables."""
        camera = mounted_camera(
            "camera",
            variables.sensor,
            variables.focal_length_mm,
            position_m=(0.0, 0.0, self.config.height_above_eye_m),
            pitch_deg=variables.pitch_deg,
            binning=self.config.binning,
        )
        return Rig((camera,))

    def derived(self, variables: Variables) -> Mapping[str, float]:
        """Fields of view and sizes of the sensor as manufactured, whatever the binning."""
        return derived_optics(variables.sensor, variables.focal_length_mm)

    def coordinates(self, variables: Variables) -> Mapping[str, float]:
        """What images depend on; see :func:`tacos_plugins.rigs.mounted_camera.image_coordinates`."""
        return image_coordinates(variables.sensor, variables.focal_length_mm, variables.pitch_deg)
