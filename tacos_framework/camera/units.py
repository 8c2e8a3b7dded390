"""Lengths on a sensor and charges, in the pixels and digital numbers of one image.

An effect belongs to the camera: a disc of 3 um is as large whatever the pitch, and ten electrons are ten
electrons at every gain. Pixels and digital numbers are those of photosites; a simulated pixel that stands for
b x b of them (`Camera.binning`) averages over them, which makes lengths in pixels b times as short, the
spread of b x b independent photosites b times as small, and leaves levels as they are.
"""

from __future__ import annotations

import math

from tacos_framework.values import ImageContext, ImageGeometry

LENGTH_UNITS = ("px", "row")
"""Units that count photosites along the image."""
CHARGE_UNITS = ("e-", "e-/s")
"""Units of charge, which a gain makes digital numbers of."""


def image_units_per(
    physical_unit: str, image_unit: str, *, geometry: ImageGeometry, context: ImageContext
) -> float | None:
    """Photosites or digital numbers of an image per physical unit.

    `physical_unit`: ``um``, ``deg/s``, ``e-``, ``e-/s`` or ``of full scale``. `image_unit`: ``px``, ``DN`` or
    ``DN/s``.

    Returns: None where the conversion gain of the camera is not known.

    Raises `ValueError` for a pair of units that do not belong together.

    >>> binned_by_4 = {"pixel_um": 12, "binning": 4}  # photosites of 3 um
    >>> geometry = ImageGeometry(160, 120, focal_length_px=250, centre_px=(79.5, 59.5), **binned_by_4)
    >>> image_units_per("um", "px", geometry=geometry, context=ImageContext())
    0.3333333333333333
    """
    match physical_unit, image_unit:
        case "um", "px":
            return geometry.binning / geometry.pixel_um
        case "deg/s", "px":
            photosites = geometry.focal_length_px * geometry.binning
            return math.radians(1) * context.exposure_s * photosites
        case ("e-", "DN") | ("e-/s", "DN/s"):
            return context.dn_per_electron
        case "of full scale", "DN":
            return context.white_level_dn + 1
    raise ValueError(f"{physical_unit} does not stand for {image_unit}")


def binned(unit: str, averaging: str | None, binning: float) -> float:
    """Factor on a number of that unit by averaging b x b photosites into a pixel [1].

    >>> binned("px", None, 4), binned("DN", "photosites", 4), binned("DN", "lines", 4), binned("DN", None, 4)
    (0.25, 0.25, 0.5, 1.0)
    """
    if unit in LENGTH_UNITS or averaging == "photosites":
        return 1 / binning
    return 1 / math.sqrt(binning) if averaging == "lines" else 1.0
