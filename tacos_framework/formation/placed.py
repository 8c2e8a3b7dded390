"""Effects and sensors as a recipe places them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from tacos_framework.contracts import Draw, SensorBase, optional
from tacos_framework.errors import Fault, UserError
from tacos_framework.plugins.guarded import blameless, calling
from tacos_framework.settings import Settings
from tacos_framework.values import Camera


@dataclass(frozen=True)
class PlacedEffect:
    """An effect, the cameras it acts on, and its settings for each."""

    use: str
    """The component, for messages."""
    name: str
    """Its name in the recipe; what it draws follows from it."""
    cls: type[Any]
    config: Settings
    by_camera: Mapping[str, Settings] = field(default_factory=dict)
    """Settings of cameras that have their own."""
    cameras: tuple[str, ...] | None = None
    """The cameras it acts on; all of them if None."""

    def config_at(self, camera: str) -> Settings | None:
        """Its settings at a camera; None where it does not act there."""
        if self.cameras is not None and camera not in self.cameras:
            return None
        return self.by_camera.get(camera, self.config)


@dataclass(frozen=True)
class PlacedControl:
    """A controller of the exposure, built: the component, for messages, and the controller."""

    use: str
    controller: Any


@dataclass(frozen=True)
class PlacedSensor:
    """A sensor model, built, and those of cameras with settings of their own."""

    use: str
    """The component, for messages."""
    name: str
    """Its node in the recipe; the noise it draws follows from it."""
    sensor: Any
    by_camera: Mapping[str, Any] = field(default_factory=dict)
    """The sensors of cameras that have their own."""

    def at(self, camera: str) -> Any:
        return self.by_camera.get(camera, self.sensor)

    def assuming(self, draw: Draw) -> PlacedSensor:
        """The sensor with one draw of what its models assume, for those that assume anything."""
        return self._each("assuming", draw)

    def behind(self, cameras: Sequence[Camera]) -> PlacedSensor:
        """The sensor behind the cameras of a rig, for one that depends on them."""
        return self._each("behind", cameras)

    def _each(self, member: str, *given: Any) -> PlacedSensor:
        """The sensors that an optional member makes of these."""
        if optional(self.sensor, SensorBase, member) is None:
            return self
        with calling(self.use, doing=member):
            by_camera = {name: getattr(sensor, member)(*given) for name, sensor in self.by_camera.items()}
            return replace(self, sensor=getattr(self.sensor, member)(*given), by_camera=by_camera)

    def range_dn(self, cameras: Sequence[str]) -> tuple[float, float]:
        """Black and white level of the files of a rig's cameras, which share them [DN].

        Raises `UserError` when the files of one camera have another range than those of the first.
        """
        first, *others = ((name, _range_dn(self.at(name))) for name in cameras)
        for name, found in others:
            if found != first[1]:
                (own, own_range), (black_dn, white_dn) = first, found
                fault = Fault(
                    f"node {self.name!r}, camera {name!r}",
                    f"files of {black_dn:g} .. {white_dn:g} DN",
                    f"{own_range[0]:g} .. {own_range[1]:g} DN, as those of camera {own!r}",
                    "Leave black level and bit depth the same for all cameras of a sensor.",
                )
                raise blameless(UserError(fault))
        return first[1]


def _range_dn(sensor: Any) -> tuple[float, float]:
    return float(sensor.black_level_dn), float(sensor.white_level_dn)
