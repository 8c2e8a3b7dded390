"""A camera ahead, and others behind and to the sides where they are wanted."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from pydantic import model_validator

from tacos_framework import Rig, setting
from tacos_plugins.rigs import several_cameras
from tacos_plugins.rigs.several_cameras import Outlook, SeveralCamerasConfig, SeveralCamerasVariables


class FrontBackSidesRig:
    """One camera ahead; with `back` one behind it, with `sides` one to the left and one to the right.

    They are called ``front``, ``left``, ``right`` and ``back``. All have the same sensor; the one ahead has a
    field of view of its own, as it may look farther than the others.

    >>> builder = FrontBackSidesRig(FrontBackSidesRig.Config())
    >>> vga = {"width_px": 640, "height_px": 480, "pixel_um": 4.8}
    >>> variables = FrontBackSidesRig.Variables(
    ...     front_hfov_deg=60, other_hfov_deg=110, sides=True, back=False, sensor=vga
    ... )
    >>> [camera.name for camera in builder.build(variables).cameras]
    ['front', 'left', 'right']
    >>> builder.derived(variables)["covered_deg"]
    280.0
    """

    class Config(SeveralCamerasConfig):
        side_yaw_deg: float = setting(
            90.0, help="Turn of the side cameras from straight ahead.", unit="deg", gt=0, lt=180
        )

    class Variables(SeveralCamerasVariables):
        """Variables that a recipe may design or fix."""

        front_hfov_deg: float = setting(
            help="Horizontal field of view of the camera ahead.", unit="deg", gt=0, lt=360
        )
        other_hfov_deg: float = setting(
            100.0, help="Horizontal field of view of each other camera.", unit="deg", gt=0, lt=360
        )
        sides: bool = setting(True, help="Add a camera to either side.")
        back: bool = setting(True, help="Add a camera behind.")

        @model_validator(mode="after")
        def _has_such_fields(self) -> FrontBackSidesRig.Variables:
            for variable in ("front_hfov_deg", "other_hfov_deg"):
                self.optics_for(variable, self.read_out.width_mm)
            return self

    derived_quantities: ClassVar[Mapping[str, str]] = {
        **several_cameras.SEVERAL_UNITS,
        "side_yaw_deg": "deg",
        "side_hfov_deg": "deg",
        "back_hfov_deg": "deg",
    }

    def __init__(self, config: Config) -> None:
        self.config = config

    def build(self, variables: Variables) -> Rig:
        """The rig of these variables, the camera ahead first."""
        return several_cameras.outward_rig(self._outlooks(variables), variables, self.config)

    def derived(self, variables: Variables) -> Mapping[str, float]:
        """Optics of the camera ahead, and what all of them come to."""
        found = several_cameras.derived_together(self._outlooks(variables), variables.read_out)
        if variables.sides:
            found |= {"side_yaw_deg": self.config.side_yaw_deg, "side_hfov_deg": variables.other_hfov_deg}
        return found | ({"back_hfov_deg": variables.other_hfov_deg} if variables.back else {})

    def coordinates(self, variables: Variables) -> Mapping[str, float]:
        """Coordinates of images of the camera ahead, the other cameras, and the view of all."""
        outlooks = self._outlooks(variables)
        return {
            **several_cameras.coordinates_of_first(outlooks, variables),
            "other_hfov_deg": variables.other_hfov_deg,
            "sides": float(variables.sides),
            "back": float(variables.back),
            "covered_deg": several_cameras.covered_deg(outlooks),
        }

    def _outlooks(self, variables: Variables) -> list[Outlook]:
        """Directions of the cameras, that ahead first."""
        other_deg, side_deg = variables.other_hfov_deg, self.config.side_yaw_deg
        lens = variables.projected()
        looks = [Outlook("front", 0.0, variables.front_hfov_deg, lens)]
        if variables.sides:
            looks += [
                Outlook(name, yaw, other_deg, lens)
                for name, yaw in (("left", side_deg), ("right", -side_deg))
            ]
        return [*looks, Outlook("back", 180.0, other_deg, lens)] if variables.back else looks
