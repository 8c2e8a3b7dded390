"""From pixels to the directions they look into, and back, through any lens.

Directions are those of the camera frame: x right, y down, z forward. They may point backwards: fisheyes see
what lies beside and behind them.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tacos_framework.values import Lens

_ROUNDING = 1e-9


class Projecting(Protocol):
    """Members that the pair needs of a `Camera`, or of an `ImageGeometry`."""

    @property
    def lens(self) -> Lens:
        """Its projection."""

    @property
    def focal_length_px(self) -> float:
        """Focal length on the optical axis [px]."""

    @property
    def centre_px(self) -> tuple[float, float]:
        """Principal point (x, y) [px]."""


def rays_of_pixels(pixels_px: ArrayLike, camera: Projecting) -> NDArray[np.float64]:
    """The directions that places of an image look into.

    `pixels_px`: (..., 2) places (x, y), inside the image or not [px].

    Returns: (..., 3) unit vectors in the camera frame; NaN outside of the image circle [1].

    A pixel a quarter of a turn off the axis of an equidistant lens looks to the right:

    >>> from tacos_framework import Camera, Lens
    >>> camera = Camera("c", 5, 5, pixel_um=1, focal_length_mm=1e-3, lens=Lens("equidistant"))
    >>> rays_of_pixels([2 + np.pi / 2, 2.0], camera).round(9).tolist()
    [1.0, 0.0, 0.0]
    """
    lens = camera.lens
    x, y = np.moveaxis((np.asarray(pixels_px, np.float64) - camera.centre_px) / camera.focal_length_px, -1, 0)
    radius = np.hypot(x, y)
    if lens.is_rectilinear:
        if any(lens.coefficients):
            seen_x, seen_y = lens.distortion.undistorted(x, y)
            back = np.hypot(*np.subtract(lens.distortion.distorted(seen_x, seen_y), (x, y)))
            x, y, radius = seen_x, seen_y, np.hypot(seen_x, seen_y)
            radius = np.where(back > 1e-6, np.inf, radius)  # beyond a fold nothing is imaged
        rays = np.stack([x, y, np.ones_like(x)], axis=-1) / np.sqrt(x**2 + y**2 + 1)[..., None]
        with np.errstate(invalid="ignore"):
            outside = np.arctan(radius) > lens.widest_rad * (1 + _ROUNDING)
        return np.where((outside | np.isinf(radius))[..., None], np.nan, rays)
    angle = lens.angle(radius)
    across = np.sin(angle) / np.where(radius > 0, radius, 1.0)
    return np.stack([x * across, y * across, np.cos(angle)], axis=-1)


def pixels_of_rays(rays: ArrayLike, camera: Projecting) -> NDArray[np.float64]:
    """Pixels of directions; undoes `rays_of_pixels`.

    `rays`: (..., 3) directions in the camera frame, of any length above 0.

    Returns: (..., 2) places (x, y), not clipped to the image; NaN for what the lens does not image [px].

    >>> from tacos_framework import Camera, Lens
    >>> camera = Camera("c", 5, 5, pixel_um=1, focal_length_mm=1e-3, lens=Lens("equisolid"))
    >>> pixels_of_rays([0.0, 2.0, 0.0], camera).round(4).tolist()
    [2.0, 3.4142]
    """
    lens = camera.lens
    x, y, z = np.moveaxis(np.asarray(rays, np.float64), -1, 0)
    across = np.hypot(x, y)
    angle = np.arctan2(across, z)
    imaged = angle <= lens.widest_rad * (1 + _ROUNDING)
    if lens.is_rectilinear:
        ahead = np.where(imaged & (z > 0), z, np.nan)
        x, y = x / ahead, y / ahead
        if any(lens.coefficients):
            x, y = lens.distortion.distorted(x, y)
        places = np.stack([x, y], axis=-1)
    else:
        scale = lens.radius(np.where(imaged, angle, np.nan)) / np.where(across > 0, across, 1.0)
        places = np.stack([x * scale, y * scale], axis=-1)
    return np.asarray(places * camera.focal_length_px + camera.centre_px)
