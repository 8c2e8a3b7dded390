"""Cameras that look outwards, evenly around the agent."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import ClassVar

from tacos_framework import Camera, Rig, Settings, setting
from tacos_framework.camera import agent_from_camera


class PanoramaRig:
    """Equal cameras on a ring, the first of which looks ahead."""

    class Config(Settings):
        """Settings of the rig: what does not vary from candidate to candidate."""

        radius_m: float = setting(0.1, help="Distance of the optical centres from the axis.", unit="m", ge=0)
        pixel_um: float = setting(3.0, help="Pitch of the photosites.", unit="um", gt=0)

    class Variables(Settings):
        """What a recipe may design or fix."""

        cameras: int = setting(4, help="Number of cameras.", ge=1, le=12)
        hfov_deg: float = setting(help="Field of view of each camera.", unit="deg", gt=0, lt=180)
        width_px: int = setting(640, help="Photosites across.", unit="px", ge=1)
        height_px: int = setting(480, help="Photosites down.", unit="px", ge=1)

    derived_quantities: ClassVar[Mapping[str, str]] = {"coverage": "1", "megapixels": "Mpx"}

    def __init__(self, config: Config) -> None:
        self.config = config

    def build(self, variables: Variables) -> Rig:
        half_width_mm = variables.width_px * self.config.pixel_um * 1e-3 / 2
        focal_length_mm = half_width_mm / math.tan(math.radians(variables.hfov_deg / 2))
        cameras = []
        for i in range(variables.cameras):
            yaw = 2 * math.pi * i / variables.cameras
            position_m = (self.config.radius_m * math.cos(yaw), self.config.radius_m * math.sin(yaw), 0.0)
            cameras.append(
                Camera(
                    name=f"camera_{i}",
                    width_px=variables.width_px,
                    height_px=variables.height_px,
                    pixel_um=self.config.pixel_um,
                    focal_length_mm=focal_length_mm,
                    agent_from_camera=agent_from_camera(position_m, 0.0, math.degrees(yaw)),
                )
            )
        return Rig(tuple(cameras))

    def derived(self, variables: Variables) -> Mapping[str, float]:
        """Share of the horizon that is seen, and pixels in all."""
        return {
            "coverage": min(variables.cameras * variables.hfov_deg / 360, 1.0),
            "megapixels": variables.cameras * variables.width_px * variables.height_px * 1e-6,
        }
