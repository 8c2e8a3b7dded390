"""What rigs of several cameras share: where the cameras sit, and what they cost together."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from tacos_framework.settings import Settings, setting
from tacos_framework.values import Rig
from tacos_plugins.rigs.mounted_camera import (
    DERIVED_UNITS,
    SensorPart,
    focal_length_for_mm,
    mounted_camera,
)

SEVERAL_UNITS = {
    **DERIVED_UNITS,
    "cameras": "1",
    "total_megapixels": "Mpx",
    "total_power_w": "W",
    "covered_deg": "deg",
}
"""Names and units of what rigs of several cameras derive: the optics of the first, and all together."""


class SeveralCamerasConfig(Settings):
    """Settings of rigs whose cameras look outwards from a circle."""

    binning: float = setting(
        1.0,
        help="Simulate blocks of binning x binning photosites as one pixel, to run on a small machine.",
        ge=1,
    )
    radius_m: float = setting(
        0.1, help="Distance of the optical centres from the agent's axis.", unit="m", ge=0, le=10
    )
    height_above_eye_m: float = setting(
        0.0, help="Height of the optical centres above the agent's eye.", unit="m"
    )


@dataclass(frozen=True)
class Outlook:
    """Where one camera looks: its name, its turn to the left [deg], its horizontal field of view [deg]."""

    name: str
    yaw_deg: float
    hfov_deg: float


def outward_rig(
    outlooks: Iterable[Outlook], sensor: SensorPart, pitch_deg: float, config: SeveralCamerasConfig
) -> Rig:
    """Equal sensors on a circle, each looking away from its middle."""

    def position_m(yaw_deg: float) -> tuple[float, float, float]:
        yaw = math.radians(yaw_deg)
        return config.radius_m * math.cos(yaw), config.radius_m * math.sin(yaw), config.height_above_eye_m

    return Rig(
        tuple(
            mounted_camera(
                each.name,
                sensor,
                focal_length_for_mm(sensor.width_mm, each.hfov_deg),
                position_m=position_m(each.yaw_deg),
                pitch_deg=pitch_deg,
                yaw_deg=each.yaw_deg,
                binning=config.binning,
            )
            for each in outlooks
        )
    )


def derived_together(outlooks: Sequence[Outlook], sensor: SensorPart) -> dict[str, float]:
    """What all cameras come to: their number, pixels and power (where it is known), and the angle in view."""
    count = len(outlooks)
    together = {
        "cameras": float(count),
        "total_megapixels": count * sensor.width_px * sensor.height_px * 1e-6,
        "covered_deg": covered_deg(outlooks),
    }
    return together if sensor.power_w is None else {**together, "total_power_w": count * sensor.power_w}


def covered_deg(outlooks: Sequence[Outlook]) -> float:
    """The angle around the agent that some camera has in view, all seen from its axis [deg].

    Examples
    --------
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
