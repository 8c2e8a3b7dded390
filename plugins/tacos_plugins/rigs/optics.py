"""Optics of a lens before a sensor: the part of a rig that fields of view follow from."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

import numpy as np
from pydantic import BeforeValidator

from tacos_framework import PINHOLE, Lens

if TYPE_CHECKING:
    from tacos_plugins.rigs.sensor_part import SensorPart

LISTED = BeforeValidator(lambda given: tuple(given) if isinstance(given, list) else given)
"""Lists of files and recipes are tuples of settings."""

Coefficients = Annotated[tuple[float, ...], LISTED]


@dataclass(frozen=True)
class Optics:
    """A lens at its focal length [mm], and its principal point in the pixels that are read out [px].

    The principal point is the middle of the image where it is None.
    """

    focal_length_mm: float
    lens: Lens = PINHOLE
    principal_point_px: tuple[float, float] | None = None

    def field_of_view_deg(self, size_mm: float) -> float:
        """The angle across a length of the sensor about its middle [mm to deg].

        >>> round(Optics(3.6).field_of_view_deg(6.2), 2)  # FLIR Flea3
        81.46
        >>> round(Optics(1.8, Lens("equidistant")).field_of_view_deg(5.7), 1)
        181.4
        """
        return self.lens.field_of_view_deg(size_mm / self.focal_length_mm)

    def dark_share(self, width_mm: float, height_mm: float) -> float:
        """Share of a sensor beyond the image circle, about its middle [1].

        >>> import math
        >>> round(Optics(1.0, Lens("equidistant", half_field_deg=90)).dark_share(math.pi, math.pi), 2)
        0.21
        """
        across, down = ((np.arange(200) + 0.5) / 200 * size / 2 for size in (width_mm, height_mm))
        return float((np.hypot(across, down[:, None]) > self.lens.image_circle * self.focal_length_mm).mean())


def notes_on_circle(optics: Optics, sensor: SensorPart) -> Iterator[str]:
    """Note on the part of the image that a lens leaves dark."""
    share = optics.dark_share(sensor.width_mm, sensor.height_mm)
    if share > 0:
        circle_mm = 2 * optics.lens.image_circle * optics.focal_length_mm
        yield (
            f"An image circle of {circle_mm:.2g} mm on a sensor of {sensor.width_mm:.2g} x "
            f"{sensor.height_mm:.2g} mm leaves {max(1, round(100 * share))} % of the image dark."
        )


def optics_for(size_mm: float, field_deg: float, lens: Lens) -> Optics:
    """The focal length at which a length of the sensor sees an angle; undoes `field_of_view_deg`.

    Raises `ValueError` where the lens has no such field of view.

    >>> round(optics_for(2.0, 90.0, Lens()).focal_length_mm, 12)
    1.0
    """
    return Optics(size_mm / lens.size_of_field(field_deg), lens)
