"""Equal cameras evenly around the agent."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import ClassVar

from pydantic import model_validator

from tacos_framework import Rig, setting
from tacos_plugins.rigs import several_cameras
from tacos_plugins.rigs.several_cameras import Outlook, SeveralCamerasConfig, SeveralCamerasVariables


class RingRig:
    """As many equal cameras as are wanted, evenly around the agent, each looking outwards.

    They are called ``camera_1``, ``camera_2`` and so on, counted to the left. How many there are may be
    designed: candidates then differ in the number of their images, and tasks that take any number of cameras
    judge them.

    >>> builder = RingRig(RingRig.Config(binning=2))
    >>> vga = {"width_px": 640, "height_px": 480, "pixel_um": 4.8}
    >>> variables = RingRig.Variables(cameras=4, hfov_deg=100, sensor=vga)
    >>> [camera.name for camera in builder.build(variables).cameras]
    ['camera_1', 'camera_2', 'camera_3', 'camera_4']
    >>> derived = builder.derived(variables)
    >>> derived["covered_deg"], round(derived["total_megapixels"], 3)
    (360.0, 1.229)
    """

    class Config(SeveralCamerasConfig):
        """Settings of the rig."""

    class Variables(SeveralCamerasVariables):
        """Variables that a recipe may design or fix."""

        cameras: int = setting(help="Number of cameras.", ge=1, le=16)
        hfov_deg: float = setting(help="Horizontal field of view of each camera.", unit="deg", gt=0, lt=360)
        first_yaw_deg: float = setting(
            0.0, help="Turn of the first camera to the left of straight ahead.", unit="deg", ge=-180, le=180
        )

        @model_validator(mode="after")
        def _has_such_a_field(self) -> RingRig.Variables:
            self.optics_for("hfov_deg", self.read_out.width_mm)
            return self

    derived_quantities: ClassVar[Mapping[str, str]] = {
        **several_cameras.SEVERAL_UNITS,
        "first_yaw_deg": "deg",
    }

    def __init__(self, config: Config) -> None:
        self.config = config

    def build(self, variables: Variables) -> Rig:
        """The rig of these variables, the first camera first."""
        return several_cameras.outward_rig(_outlooks(variables), variables, self.config)

    def derived(self, variables: Variables) -> Mapping[str, float]:
        """Optics of one camera, and what all of them come to."""
        together = several_cameras.derived_together(_outlooks(variables), variables.read_out)
        return {**together, "first_yaw_deg": variables.first_yaw_deg}

    def coordinates(self, variables: Variables) -> Mapping[str, float]:
        """Coordinates of images of each camera, their number, and the agent's direction between two.

        A ring that is turned by its spacing is the same ring, so its turn counts as an angle of that circle.
        """
        outlooks = _outlooks(variables)
        phase = math.radians(variables.first_yaw_deg * variables.cameras)
        return {
            **several_cameras.coordinates_of_first(outlooks, variables),
            "log2_cameras": math.log2(variables.cameras),
            "covered_deg": several_cameras.covered_deg(outlooks),
            "cos_turn": math.cos(phase),
            "sin_turn": math.sin(phase),
        }


def _outlooks(variables: RingRig.Variables) -> list[Outlook]:
    spacing_deg, lens = 360 / variables.cameras, variables.projected()
    return [
        Outlook(f"camera_{i + 1}", variables.first_yaw_deg + i * spacing_deg, variables.hfov_deg, lens)
        for i in range(variables.cameras)
    ]
