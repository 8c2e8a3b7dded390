"""Fisheyes whose radius has further powers of the angle off the axis, as Kannala and Brandt's model has."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Lens

Array = NDArray[np.float64]

WIDEST_RAD = math.radians(89)
"""A flat image ends before 90 degrees off the axis."""

_ROUNDS = 8
_STEP_RAD = 1e-5
_LEAST_SLOPE = 0.05
"""Below it a lens folds its image: nothing is imaged there."""


def powers_beyond(radius: Array, angle_rad: Array, lens: Lens, terms: int) -> tuple[float, ...]:
    """The coefficients (k1, ..) of t^3, t^5, .. that images of angles have beyond a lens, by least squares.

    - `radius`: (K,) where the angles are imaged [focal lengths].
    - `lens`: of a rectilinear one the coefficients are those of Kannala and Brandt's model.

    Returns: four, those beyond `terms` 0 [1].
    """
    powers = angle_rad[:, None] ** (3 + 2 * np.arange(terms))
    found = np.linalg.lstsq(powers, radius - _own_radius(lens, angle_rad), rcond=None)[0]
    return tuple(float(each) for each in np.append(found, np.zeros(4 - terms)))


def radius_without(radius: Array, coefficients: tuple[float, ...], lens: Lens) -> Array:
    """The radius at which a lens images what one of further powers of the angle images at `radius`.

    Where a rectilinear lens has no image, beyond `WIDEST_RAD`, that of its edge [focal lengths].
    """
    if lens.is_rectilinear:
        fisheye = Lens("kannala-brandt", coefficients)
        return np.tan(np.minimum(np.nan_to_num(fisheye.angle(radius), nan=fisheye.widest_rad), WIDEST_RAD))
    whole = replace(lens, half_field_deg=None)
    angle = np.nan_to_num(whole.angle(radius), nan=whole.widest_rad)
    for _ in range(_ROUNDS):
        here, beyond = (_with_powers(whole, angle + step, coefficients) for step in (0.0, _STEP_RAD))
        slope = np.maximum((beyond - here) / _STEP_RAD, _LEAST_SLOPE)
        angle = np.clip(angle + (radius - here) / slope, 0.0, whole.widest_rad)
    return whole.radius(angle)


def _with_powers(lens: Lens, angle_rad: Array, coefficients: tuple[float, ...]) -> Array:
    return lens.radius(angle_rad) + angle_rad * np.polynomial.polynomial.polyval(
        angle_rad**2, (0.0, *coefficients)
    )


def _own_radius(lens: Lens, angle_rad: Array) -> Array:
    return angle_rad if lens.is_rectilinear else lens.radius(angle_rad)
