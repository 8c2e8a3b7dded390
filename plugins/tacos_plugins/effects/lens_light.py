"""How much light a lens leaves for each direction."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from tacos_framework import ImageGeometry

_STEP_RAD = 1e-4


@lru_cache(maxsize=8)
def relative_illumination(geometry: ImageGeometry, power: float = 1.0) -> NDArray[np.float64]:
    """(H, W) illuminance under an even scene, over that on the axis; 0 beyond the image circle [1].

    With the angle t off the axis and a projection r(t), light of a solid angle falls on an area:

        E(t) / E(0) = A(t) / A(0) sin t / (r r')

    with A the area of the entrance pupil as seen from there. Of a rectilinear lens the pupil is a flat disc,
    A(t) = A(0) cos t, and E = cos^4 t. That of a fisheye turns to the light, or nothing would be seen at 90
    degrees: A is taken as constant, and an equisolid image is as bright everywhere. Distortion counts, but
    for its tangential part.

    `power`: of the whole [1].

    Sources: Kingslake 1992, "Optics in Photography", ch. 7, on cos^4; Kumler and Bauer 2000, "Fish-eye lens
    designs and their relative performance", SPIE 4093, on pupils of fisheyes.
    """
    lens = geometry.lens
    angle = lens.angle(geometry.radius * geometry.half_diagonal_px / geometry.focal_length_px)
    inner, outer = np.maximum(angle - _STEP_RAD, 0.0), angle + _STEP_RAD
    solid_angle = np.cos(inner) - np.cos(outer)
    if lens.is_rectilinear:
        solid_angle *= np.cos(angle)
    area = (lens.radius(outer) ** 2 - lens.radius(inner) ** 2) / 2
    light = np.nan_to_num(np.maximum(solid_angle / area, 0.0) ** power)
    light.flags.writeable = False
    return light
