"""Shared parts of rigs of several cameras: settings, places and costs."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from tacos_framework import PINHOLE, Lens, Rig, setting
from tacos_plugins.rigs.mounted_camera import (
    DERIVED_UNITS,
    MountSettings,
    ReadOutVariables,
    derived_optics,
    image_coordinates,
    mounted_camera,
    tilt_of,
)
from tacos_plugins.rigs.optics import Optics, optics_for
from tacos_plugins.rigs.sensor_part import SensorPart

SEVERAL_UNITS = {
    **DERIVED_UNITS,
    "cameras": "1",
    "total_megapixels": "Mpx",
    "total_power_w": "W",
    "covered_deg": "deg",
}
"""Names and units of what rigs of several cameras derive: the optics of the first, and all together."""


class SeveralCamerasConfig(MountSettings):
    """Settings of rigs whose cameras look outwards from a circle."""

    radius_m: float = setting(
        0.1, help="Distance of the optical centres from the agent's axis.", unit="m", ge=0, le=10
    )


class SeveralCamerasVariables(ReadOutVariables):
    """Variables that a recipe may design or fix of all cameras alike."""

    pitch_deg: float = tilt_of("all cameras")


@dataclass(frozen=True)
class Outlook:
    """Direction of one camera: its name, its turn to the left [deg], its horizontal field of view [deg].

    Its lens has the projection of the rig's.
    """

    name: str
    yaw_deg: float
    hfov_deg: float
    lens: Lens = PINHOLE

    def optics(self, sensor: SensorPart) -> Optics:
        return optics_for(sensor.width_mm, self.hfov_deg, self.lens)


def outward_rig(
    outlooks: Iterable[Outlook], variables: SeveralCamerasVariables, config: SeveralCamerasConfig
) -> Rig:
    """Equal sensors on a circle, each looking away from its middle."""

    def position_m(yaw_deg: float) -> tuple[float, float, float]:
        yaw = math.radians(yaw_deg)
        return config.radius_m * math.cos(yaw), config.radius_m * math.sin(yaw), config.height_above_eye_m

    return Rig(
        tuple(
            mounted_camera(
                each.name,
                variables,
                each.optics(variables.read_out),
                position_m=position_m(each.yaw_deg),
                pitch_deg=variables.pitch_deg,
                yaw_deg=each.yaw_deg,
                binning=config.binning,
            )
            for each in outlooks
        )
    )


def derived_together(outlooks: Sequence[Outlook], sensor: SensorPart) -> dict[str, float]:
    """Optics of the first camera, and what all come to: number, pixels, power if it is known, angle in view.

    `outlooks`: where the cameras look, at least one. `sensor`: what is read out of each.
    """
    count = len(outlooks)
    together = {
        **derived_optics(sensor, outlooks[0].optics(sensor)),
        "cameras": float(count),
        "total_megapixels": count * sensor.width_px * sensor.height_px * 1e-6,
        "covered_deg": covered_deg(outlooks),
    }
    return together if sensor.power_w is None else {**together, "total_power_w": count * sensor.power_w}


def coordinates_of_first(outlooks: Sequence[Outlook], variables: SeveralCamerasVariables) -> dict[str, float]:
    """Coordinates of images of the first camera; see :func:`image_coordinates` of ``mounted_camera``."""
    return image_coordinates(variables.read_out, outlooks[0].optics(variables.read_out), variables.pitch_deg)


def covered_deg(outlooks: Sequence[Outlook]) -> float:
    """The angle around the agent that some camera has in view, all seen from its axis [deg].

    >>> covered_deg([Outlook("front", 0, 90), Outlook("left", 60, 90)])
    150.0
    >>> covered_deg([Outlook("front", 0, 90), Outlook("left", 90, 90), Outlook("back", 200, 170)])
    330.0
    """
    starts = [((each.yaw_deg - each.hfov_deg / 2) % 360, each.hfov_deg) for each in outlooks]
    spans = [(start, min(start + width, 360.0)) for start, width in starts]
    spans += [(0.0, start + width - 360) for start, width in starts if start + width > 360]
    covered, reached = 0.0, 0.0
    for start, end in sorted(spans):
        covered += max(0.0, end - max(start, reached))
        reached = max(reached, end)
    return covered
