"""Images of points through a lens, and their derivatives."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tacos_framework import ImageGeometry
from tacos_framework.camera import pixels_of_rays

Array = NDArray[np.float64]

_STEP = 1e-4  # of a point's distance


def imaged(points_mm: Array, geometry: ImageGeometry, *, derivatives: bool = True) -> tuple[Array, Array]:
    """Images through a lens of points in the camera's frame.

    Returns: (K, 2) places [px], and how they move with the points (2, K, 3), without `derivatives` nothing
    [px/mm].
    """
    if not geometry.lens.is_pinhole:
        return _through_lens(points_mm, geometry, derivatives)
    x, y, z = points_mm.T
    f = geometry.focal_length_px
    z = np.where(np.abs(z) < 1e-6, 1e-6, z)
    places = f * np.column_stack([x / z, y / z]) + geometry.centre_px
    if not derivatives:
        return places, np.zeros((2, 0, 3))
    none = np.zeros_like(z)
    return places, np.stack([[f / z, none, -f * x / z**2], [none, f / z, -f * y / z**2]]).transpose(0, 2, 1)


def _through_lens(points_mm: Array, geometry: ImageGeometry, derivatives: bool) -> tuple[Array, Array]:
    def seen(points: Array) -> Array:
        return _kept(pixels_of_rays(points, geometry), geometry)

    places = seen(points_mm)
    if not derivatives:
        return places, np.zeros((2, 0, 3))
    step = _STEP * np.linalg.norm(points_mm, axis=1)[:, None, None] * np.eye(3)  # (K, 3, 3)
    change = seen(points_mm[:, None] + step) - seen(points_mm[:, None] - step)
    return places, (change / (2 * step.max(axis=2, keepdims=True))).transpose(2, 0, 1)


def _kept(places: Array, geometry: ImageGeometry) -> Array:
    """Places, those of what is not imaged far outside: poses on the way to a good one may be such."""
    return np.where(np.isnan(places), np.add(geometry.centre_px, 10 * geometry.half_diagonal_px), places)
