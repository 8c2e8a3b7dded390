"""Settings that were found on images, in physical units: what `in_image_units` undoes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tacos_framework import (
    ImageContext,
    ImageGeometry,
    Settings,
    includes_pedestal,
    physical_settings,
    unit_of,
)
from tacos_framework.camera import image_units_per


def physical_settings_of(
    kind: type[Settings], values: Mapping[str, Any], geometry: ImageGeometry, context: ImageContext
) -> dict[str, tuple[str, float]]:
    """Settings in pixels and digital numbers of a camera's photosites, in physical units.

    Returns: setting -> physical setting and its value, where there is one and the camera is known well
    enough.
    """
    found = {}
    for name, image_name in physical_settings(kind).items():
        value = values.get(image_name)
        if not isinstance(value, int | float):
            continue
        unit = unit_of(kind, name)
        per = image_units_per(unit, unit_of(kind, image_name), geometry=geometry, context=context)
        if per:
            pedestal = context.black_level_dn if includes_pedestal(kind, image_name) else 0.0
            found[image_name] = (name, (value - pedestal) / per)
    return found
