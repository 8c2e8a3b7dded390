"""The plane of focus beside a flat thing, from how far tiles of a picture are out of focus."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_framework import ObservedCapture
from tacos_plugins.effects.disc_radius import BLURRED, SHARP, disc_fits, mean_image, power_spectrum

_TILES, _TILE_PX = 6, (32, 80)
"""Tiles over the shorter side, and their least and largest side."""

_FEWEST_TILES = 12
_LEAST_TEXTURE = 0.1
"""Standard deviation of a tile over that of the whole picture below which it tells nothing."""

_WORTH = 0.7
"""Share of the radii's spread that a plane may leave."""

_DIRECTIONS, _WAYS = 8, (-0.5, 0.0, 0.5, 2.0)
"""Where the line of sharpness may run: directions, and distances from the middle [half the width]."""


@dataclass(frozen=True)
class FocusPlane:
    """Radius of the disc at the principal point [px], and its growth to the right and downwards [px/px].

    The radius has a sign, which changes where the image is sharp; it is not negative at the principal point.
    """

    radius_px: float
    slope_x: float
    slope_y: float


def tilted_plane(capture: ObservedCapture) -> FocusPlane | None:
    """The plane that the radii of tiles lie in; None where one radius for all does about as well."""
    tiles = _radii_of_tiles(capture)
    if len(tiles) < _FEWEST_TILES:
        return None
    x, y, radius = tiles.T
    half = capture.geometry.full_width_px / 2
    spread = float(np.abs(radius - np.median(radius)).sum())
    fits = [
        _plane_through(x / half, y / half, radius, np.where(beyond, 1.0, -1.0))
        for turn in np.arange(_DIRECTIONS) * 2 * math.pi / _DIRECTIONS
        for way in _WAYS
        if (beyond := math.cos(turn) * x / half + math.sin(turn) * y / half + way > 0).any()
    ]
    left, plane = min(fits, key=lambda fit: fit[0])
    if left >= _WORTH * spread:
        return None
    plane = plane if plane[0] > 0 else -plane
    return FocusPlane(float(plane[0]), float(plane[1] / half), float(plane[2] / half))


def _radii_of_tiles(capture: ObservedCapture) -> NDArray[np.float64]:
    """(T, 3) tiles that tell how far they are out of focus: x and y from the principal point, radius [px]."""
    if capture.expected_dn is None or capture.own_edges:
        return np.empty((0, 3))
    real, expected = mean_image(capture.real_dn), mean_image(capture.expected_dn)
    least = _LEAST_TEXTURE * float(expected.std())
    places, pairs = [], []
    height, width = expected.shape
    side = int(np.clip(min(height, width) // _TILES, *_TILE_PX))
    for top in range(0, height - side + 1, side):
        for left in range(0, width - side + 1, side):
            tile = np.s_[top : top + side, left : left + side]
            if capture.valid[tile].all() and expected[tile].std() > least:
                places.append((left + (side - 1) / 2, top + (side - 1) / 2))
                inside = capture.valid[tile]
                pairs.append((power_spectrum(real[tile], inside), power_spectrum(expected[tile], inside)))
    found = []
    centre = capture.geometry.centre_px
    for (x, y), fit in zip(places, disc_fits(pairs) if pairs else (), strict=True):
        if fit is not None and not BLURRED <= fit.left <= SHARP:
            radius = fit.radius_px if fit.left < BLURRED else 0.0
            found.append((x - centre[0], y - centre[1], radius))
    return np.array(found).reshape(-1, 3)


def _plane_through(
    x: NDArray[np.float64], y: NDArray[np.float64], radius: NDArray[np.float64], side: NDArray[np.float64]
) -> tuple[float, NDArray[np.float64]]:
    """The plane whose absolute value is (T,) radii, from a guess of the (T,) side of focus that tiles are on.

    By least absolute deviations: things that stand out of a flat one are out of its plane.

    Returns: the sum of what is left, and (3,) the plane's value in the middle and its slopes.
    """
    from scipy.optimize import least_squares

    terms = np.stack([np.ones_like(x), x, y], axis=1)
    begun = np.linalg.lstsq(terms, side * radius, rcond=None)[0]

    def missed(plane: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.abs(terms @ plane) - radius

    plane = least_squares(missed, begun, loss="soft_l1").x
    return float(np.abs(missed(plane)).sum()), plane
