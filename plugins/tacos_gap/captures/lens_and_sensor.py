"""Where the files of a capture lie on the sensor, and what of the lens is nobody's claim."""

from __future__ import annotations

from tacos_framework.values import ImageGeometry
from tacos_gap.captures.entries import CaptureCamera, CaptureEntry, CropEntry

FOCAL_LENGTH_MM = 4.0
"""Stands for a focal length that nobody stated, until boards tell it."""


def unstated(camera: CaptureCamera) -> frozenset[str]:
    """What of the lens is nobody's claim: a centre that goes without saying is one, beside a focal length."""
    if camera.focal_length_mm is not None:
        return frozenset()
    return frozenset({"focal_length", *(() if camera.principal_point_px else ("principal_point",))})


def geometry_of(camera: CaptureCamera, entry: CaptureEntry | None) -> ImageGeometry:
    """Where the files of a capture lie on the sensor; those of the camera itself for None.

    Raises
    ------
    ValueError
        When they do not lie on it.
    """
    width = (entry and entry.width_px) or camera.width_px
    height = (entry and entry.height_px) or camera.height_px
    own_crop = entry.crop if entry else None
    crop = own_crop or camera.crop or CropEntry(full_width_px=width, full_height_px=height)
    centre = camera.principal_point_px
    if centre is None:
        centre = ((crop.full_width_px - 1) / 2 - crop.x, (crop.full_height_px - 1) / 2 - crop.y)
    elif own_crop is not None:
        base = camera.crop
        centre = (centre[0] + (base.x if base else 0) - crop.x, centre[1] + (base.y if base else 0) - crop.y)
    return ImageGeometry(
        width_px=width,
        height_px=height,
        focal_length_px=(camera.focal_length_mm or FOCAL_LENGTH_MM) * 1e3 / camera.pixel_um,
        centre_px=centre,
        pixel_um=camera.pixel_um,
        offset_px=(crop.x, crop.y),
        full_width_px=crop.full_width_px,
        full_height_px=crop.full_height_px,
    )
