"""Sizes that parts of cameras have, so that a slip of the unit is doubted aloud."""

from __future__ import annotations

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


def implausible(values: Mapping[str, Value]) -> Iterator[str]:
    """Sentences on numbers that are a slip of the unit rather than a part."""
    for name, value in values.items():
        if not isinstance(value, int | float) or name not in PLAUSIBLE:
            continue
        lower, upper = PLAUSIBLE[name]
        if not lower <= value <= upper:
            yield f"{name} is {value:g}; parts have {lower:g} to {upper:g}. Is it in another unit?"
