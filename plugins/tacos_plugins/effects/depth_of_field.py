"""Blur that depends on depth, with near things before far ones."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from tacos_framework import ImageGeometry
from tacos_plugins.effects.blur import blur
from tacos_plugins.effects.disc import disc_kernel

LARGEST_RADIUS_PX = 100.0
"""Wider discs are drawn at this radius [px]."""

_STEP = 1.12  # from each radius to the next
_FINEST_PX = 0.25
_OCCLUDES_PX = 2.0  # layers whose radii differ by less belong to one surface


def signed_radius(
    depth_m: NDArray[np.floating], geometry: ImageGeometry, *, f_number: float, focus_m: float
) -> NDArray[np.float64]:
    """Radius of the circle of confusion of a thin lens; negative before the distance of focus.

        R = A f (1 / s - 1 / Z) / (2 (1 - f / s)),    A = f / N

    with the aperture A, the distance of focus s and the depth Z.

    - `depth_m`: (...) depth Z, infinite where nothing is [m].
    - `geometry`: gives the focal length f and the pixel pitch.
    - `f_number`: N [1].
    - `focus_m`: s; taken as just beyond the focal length where it is nearer [m].

    Returns: same shape, within `LARGEST_RADIUS_PX` [px].

    A 50 mm lens at f/2 focused on 2 m, pixels of 5 um; the textbook gives 0.641 mm across for infinity:

    >>> geometry = ImageGeometry(8, 8, focal_length_px=1e4, centre_px=(3.5, 3.5), pixel_um=5)
    >>> radius = signed_radius(np.array([1.0, 2.0, np.inf]), geometry, f_number=2.0, focus_m=2.0)
    >>> radius.round(1).tolist()
    [-64.1, 0.0, 64.1]
    """
    f_m = geometry.focal_length_px * geometry.pixel_um * 1e-6
    focus_m = max(focus_m, 1.01 * f_m)
    vergence = 1 / focus_m - 1 / np.asarray(depth_m, dtype=np.float64)
    radius_m = f_m**2 / f_number * vergence / (2 * (1 - f_m / focus_m))
    return np.clip(radius_m / (geometry.pixel_um * 1e-6), -LARGEST_RADIUS_PX, LARGEST_RADIUS_PX)


def blur_by_depth(light: NDArray[np.floating], radius_px: NDArray[np.floating]) -> NDArray[np.floating]:
    """Light spread over discs whose radius follows from depth.

    The image is cut into layers of about equal radius, each blurred by itself. A layer is covered by layers
    that lie clearly nearer, as far as their blur reaches; neighbouring layers share a surface and add up.

    `light`: (N, H, W, C) float32 or float64. `radius_px`: (N, H, W) radius of each pixel's disc, rising with
    depth: negative is before the focus [px].

    Returns: same shape and dtype.
    """
    blurred = np.empty_like(light)
    for frame, radius, out in zip(light, radius_px, blurred, strict=True):
        out[...] = np.clip(_composed(frame, radius), frame.min(), frame.max())
    return blurred


def _composed(frame: NDArray[np.floating], radius_px: NDArray[np.floating]) -> NDArray[np.floating]:
    total = np.zeros(frame.shape)
    weight = np.zeros((*frame.shape[:2], 1))
    nearer: list[tuple[float, NDArray[np.float64]]] = []
    for radius, share in _layers(radius_px):
        layer = np.concatenate([frame * share[..., None], share[..., None]], axis=-1, dtype=np.float64)
        if radius:
            layer = blur(layer[None], disc_kernel(abs(radius)))[0]
        cover = layer[..., -1:]
        covered = sum((c for r, c in nearer if radius - r > _OCCLUDES_PX), start=np.zeros_like(cover))
        free = np.clip(1 - covered, 0.0, 1.0)
        total += free * layer[..., :-1]
        weight += free * cover
        nearer.append((radius, cover))
    return total / np.maximum(weight, 1e-6)


def _layers(radius_px: NDArray[np.floating]) -> Iterator[tuple[float, NDArray[np.float64]]]:
    """Radii from near to far, and each pixel's share in them; the shares of a pixel come to 1.

    Between two radii the shares are such that the variance of the spread is right.
    """
    steps = [0.0]
    while steps[-1] < np.abs(radius_px).max():
        steps.append(max(steps[-1] * _STEP, steps[-1] + _FINEST_PX))
    radii = np.array([-radius for radius in steps[:0:-1]] + steps)
    squares = np.sign(radii) * radii**2
    position = np.interp(np.sign(radius_px) * radius_px**2, squares, np.arange(len(radii)))
    for i, radius in enumerate(radii):
        share = np.clip(1 - np.abs(position - i), 0.0, 1.0)
        if share.any():
            yield float(radius), share
