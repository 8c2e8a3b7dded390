"""What a lens does from the axis to the edge of its field, in focal lengths, whatever its size."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from tacos_lens_prescription.prescription import TRIPLET, Floats, Prescription, read_prescription

ANGLES_RAD = np.radians(np.arange(0.0, 70.0))
RAYS_ACROSS = 161


@dataclass(frozen=True)
class Field:
    """(K,) by field angle, in units of the focal length: up to where light passes.

    Parameters
    ----------
    tangent
        Tangent of the field angle: where a pinhole images it.
    height
        Where the chief ray, through the middle of the stop, meets the image.
    light
        Illuminance over that on the axis [1].
    blur
        Standard deviation of the spot along one axis, the mean of both.
    """

    tangent: Floats
    height: Floats
    light: Floats
    blur: Floats


@lru_cache(maxsize=16)
def field_of(path: str, f_number: float) -> Field:
    """The table of the lens in a file, of the triplet where none is named, at an f-number."""
    return traced(read_prescription(Path(path or TRIPLET)), f_number)


def traced(lens: Prescription, f_number: float) -> Field:
    """The table of a lens.

    The illuminance is the light of an even scene that gets in, over the image it is spread on:

        E(t) / E(0) = A(t) / A(0) d(sin^2 t) / d(h^2)

    with t the angle, h the height of the chief ray in focal lengths, and A the area of the beam in the plane
    of the first vertex. Without distortion, and with the whole beam, that is the fourth power of the cosine.
    """
    focal_mm, stop_mm = lens.focal_length_mm, lens.stop_radius_mm(f_number)
    reach_mm = 1.5 * lens.surfaces[0].semi_diameter_mm
    across = np.linspace(-reach_mm, reach_mm, RAYS_ACROSS)
    grid = np.column_stack([each.ravel() for each in np.meshgrid(across, across)])
    fan = np.column_stack([np.zeros(2001), np.linspace(-reach_mm, reach_mm, 2001)])
    heights, areas, blurs = [], [], []
    for angle in ANGLES_RAD:
        beam, chief = lens.trace(grid, angle, stop_mm), lens.trace(fan, angle)
        at_stop, at_image = chief.stop_mm[chief.passed, 1], chief.image_mm[chief.passed, 1]
        if beam.passed.sum() < 2 or not at_stop.min(initial=1.0) <= 0 <= at_stop.max(initial=-1.0):
            break
        heights.append(np.interp(0.0, at_stop, at_image) / focal_mm)
        areas.append(beam.passed.sum())
        blurs.append(np.sqrt(beam.image_mm[beam.passed].var(axis=0).mean()) / focal_mm)
    angles, height, area = ANGLES_RAD[: len(heights)], np.array(heights), np.array(areas, float)
    spread = np.gradient(np.sin(angles) ** 2, height**2, edge_order=2)
    return Field(np.tan(angles), height, area * spread / (area * spread)[0], np.array(blurs))
