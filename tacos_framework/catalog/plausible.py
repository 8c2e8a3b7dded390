"""Sizes that parts of cameras have, so that a slip of the unit is doubted aloud."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping

from tacos_framework.values.catalog_part import Value

PLAUSIBLE: Mapping[str, tuple[float, float]] = {
    "pixel_um": (0.4, 60.0),
    "width_mm": (0.5, 120.0),
    "height_mm": (0.5, 120.0),
    "width_px": (8, 40_000),
    "height_px": (8, 40_000),
    "focal_length_mm": (0.2, 3000.0),
    "f_number": (0.5, 64.0),
    "image_circle_mm": (0.5, 200.0),
    "full_well_e": (100.0, 5e6),
    "read_noise_e": (0.01, 2000.0),
}
"""Columns and the range that parts for sale keep, each with a factor of about two to spare."""


FORMAT_SHARE = (0.55, 0.8)
"""Diagonal of an image sensor over its optical format, which is named by the diameter of a camera tube."""

FIELD_TOLERANCE = 1.1
"""Factor by which a field of view may leave what lenses of any projection have at a focal length."""

_FORMAT = re.compile(r"(\d*\.?\d+)(?:/(\d*\.?\d+))?")


def implausible(values: Mapping[str, Value]) -> Iterator[str]:
    """Sentences on numbers that are a slip of the unit rather than a part."""
    for name, value in values.items():
        if not isinstance(value, int | float) or name not in PLAUSIBLE:
            continue
        lower, upper = PLAUSIBLE[name]
        if not lower <= value <= upper:
            yield f"{name} is {value:g}; parts have {lower:g} to {upper:g}. Is it in another unit?"
    width, height = (values.get(name) for name in ("width_mm", "height_mm"))
    if isinstance(width, float) and isinstance(height, float):
        yield from _clash_with_format(math.hypot(width, height), values.get("optical_format"))
    if isinstance(width, float):
        yield from _clash_with_field(width, values.get("focal_length_mm"), values.get("hfov_deg"))


def _clash_with_format(diagonal_mm: float, optical_format: Value) -> Iterator[str]:
    """The clash of pixels and pitch with an optical format."""
    found = _FORMAT.match(optical_format) if isinstance(optical_format, str) else None
    if found is None:
        return
    tube_mm = 25.4 * float(found[1]) / float(found[2] or 1)
    least_mm, most_mm = (share * tube_mm for share in FORMAT_SHARE)
    if not least_mm <= diagonal_mm <= most_mm:
        yield (
            f"Pixels and pitch make a diagonal of {diagonal_mm:.2f} mm; sensors of format {optical_format} "
            f"have {least_mm:.1f} to {most_mm:.1f}. Correct the pixels, the pitch or the format."
        )


def _clash_with_field(width_mm: float, focal_length_mm: Value, hfov_deg: Value) -> Iterator[str]:
    """The clash of a focal length with a field of view, of a rectilinear lens or a fisheye."""
    if not isinstance(focal_length_mm, float) or not isinstance(hfov_deg, float) or focal_length_mm <= 0:
        return
    ratio = width_mm / (2 * focal_length_mm)
    rectilinear, equidistant = math.degrees(2 * math.atan(ratio)), math.degrees(2 * ratio)
    if not rectilinear / FIELD_TOLERANCE <= hfov_deg <= equidistant * FIELD_TOLERANCE:
        yield (
            f"hfov_deg is {hfov_deg:g}, where {width_mm:.3g} mm behind {focal_length_mm:g} mm make "
            f"{rectilinear:.1f} (rectilinear) to {equidistant:.1f} (equidistant). Correct one of the three."
        )
