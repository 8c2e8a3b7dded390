"""Place of a capture's files on the sensor, and facts of the lens that are not stated."""

from __future__ import annotations

from tacos_framework import ImageGeometry, Lens
from tacos_gap.captures.entries import CaptureCamera, CaptureEntry, CropEntry

FOCAL_LENGTH_MM = 4.0
"""Stands for a focal length that nobody stated, until boards tell it."""


def unstated(camera: CaptureCamera) -> frozenset[str]:
    """Facts of the lens that are not stated; a lens stands a percent off the middle unless stated.

    A data sheet states a focal length, and never a principal point.
    """
    start = camera.lens_is_a_start
    stated = (("focal_length", camera.focal_length_mm), ("principal_point", camera.principal_point_px))
    return frozenset(name for name, value in stated if start or value is None)


def filters_of(camera: CaptureCamera, entry: CaptureEntry) -> str | None:
    """The colour filters of a capture's files: a crop of its own may begin in another row or column of them.

    The camera's are those of files that lie where it says. Where it does not say, and its files are no whole
    frames, they are taken as stated: from the top-left pixel of every file on.
    """
    if camera.cfa is None or entry.crop is None:
        return camera.cfa
    base = camera.crop
    if base is None and (camera.width_px, camera.height_px) != _full_size_px(entry.crop):
        return camera.cfa
    base_x, base_y = (base.x, base.y) if base else (0, 0)
    return moved_filters(camera.cfa, entry.crop.x - base_x, entry.crop.y - base_y)


def _full_size_px(crop: CropEntry) -> tuple[int, int]:
    return crop.full_width_px, crop.full_height_px


def moved_filters(cfa: str, columns: int, rows: int) -> str:
    """The colour filters of a mosaic from so many columns and rows further on.

    >>> moved_filters("RGGB", 1, 0), moved_filters("RGGB", 1, -1)
    ('GRBG', 'BGGR')
    """
    return "".join(cfa[(y + rows) % 2 * 2 + (x + columns) % 2] for y in (0, 1) for x in (0, 1))


def geometry_of(camera: CaptureCamera, entry: CaptureEntry | None) -> ImageGeometry:
    """Place of a capture's files on the sensor; those of the camera itself for None.

    Raises ValueError when they do not lie on it.
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
        lens=Lens(camera.projection, camera.lens_coefficients),
    )
