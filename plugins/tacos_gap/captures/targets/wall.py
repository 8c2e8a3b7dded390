"""A wall: an even surface, whose level and shading its own pictures tell."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import cv2
import numpy as np
from numpy.polynomial.polynomial import polygrid2d
from numpy.typing import NDArray

TILES = 24
"""Tiles along the longer side that the shading is fitted to."""

_DEGREE = 4
_POWERS = [(i, j) for i in range(_DEGREE + 1) for j in range(_DEGREE + 1 - i)]
"""Powers of x and y in a surface of that degree."""

_EVEN = 0.005
"""Deviation of an even surface from smooth light that is negligible, over its level: scenes have more."""
_BEYOND_CHANCE = 2.0
"""Variance of tiles, over that of means of as many independent pixels, from which on they have something in
common."""
_CORRELATED = 0.25
"""Largest correlation of neighbours in what a sensor adds; in scenes they are alike."""


def level_at(plane: NDArray[np.float32], centre_px: tuple[float, float]) -> float:
    """The level of an even surface at the principal point, where no lens darkens it [DN].

    `plane`: (H, W) mean of the frames of one channel [DN]. `centre_px`: principal point (x, y) in the files;
    one outside is brought to the nearest pixel [px].
    """
    height, width = plane.shape
    x = (float(np.clip(centre_px[0], 0, width - 1)) + 0.5) / width * 2 - 1
    y = (float(np.clip(centre_px[1], 0, height - 1)) + 0.5) / height * 2 - 1
    return float((_terms(np.array([x]), np.array([y])) @ _shading_of(plane))[0])


def shading(plane: NDArray[np.float32], *, has_defects: bool = True) -> NDArray[np.float32]:
    """(H, W) the smooth part of an even surface's picture, all its noise and patterns left out [DN].

    `plane`: (H, W) the picture [DN]. `has_defects`: whether single pixels may stand out, which then do not
    count; noise alone is averaged best as it is.
    """
    coefficients = np.zeros((_DEGREE + 1, _DEGREE + 1))
    coefficients[tuple(zip(*_POWERS, strict=True))] = _shading_of(plane, has_defects)
    height, width = map(_centres, plane.shape)
    return polygrid2d(width, height, coefficients).T.astype(np.float32)


def smooth_light(light: NDArray[np.float64], *, mosaic: bool) -> NDArray[np.float64] | None:
    """(H, W, C) the smooth part of light on an even surface; None where the light is that of a scene.

    What an image sensor adds from pixel to pixel is left out, so that it is not taken for the surface's own.

    - `light`: (H, W, C), of any unit.
    - `mosaic`: as in `even_expectation`.
    """
    smooth = np.empty_like(light)
    for plane in _planes(light.shape[-1], mosaic):
        seen = np.ascontiguousarray(light[plane], np.float32)
        even = shading(seen)
        if not _is_of_pixels(seen - even, _EVEN * float(seen.mean())):
            return None
        smooth[plane] = even
    return smooth


def _is_of_pixels(rest: NDArray[np.float32], negligible: float) -> bool:
    """True if an (H, W) picture varies from pixel to pixel alone, in tiles by chance."""
    tiles, variance = _in_tiles(rest), float(rest.var())
    chance = variance * tiles.size / rest.size
    beside = float(np.mean(rest[:, 1:] * rest[:, :-1]) + np.mean(rest[1:] * rest[:-1])) / 2
    alike = float(np.mean(tiles**2)) > negligible**2 + _BEYOND_CHANCE * chance
    return not alike and abs(beside) <= negligible**2 + _CORRELATED * variance


def even_expectation(
    mean_dn: NDArray[np.float32], centre_px: tuple[float, float], *, mosaic: bool
) -> NDArray[np.float32]:
    """(H, W, C) what evenly lit paper would give without any lens: one level per channel.

    - `mean_dn`: (H, W, C) mean of the frames [DN].
    - `centre_px`: principal point in the files [px].
    - `mosaic`: true if the one channel holds a colour filter array, whose four phases have levels of their
      own.
    """
    expected = np.empty_like(mean_dn)
    for plane in _planes(mean_dn.shape[-1], mosaic):
        rows, columns, _ = plane
        centre = (centre_px[0] - columns.start) / columns.step, (centre_px[1] - rows.start) / rows.step
        expected[plane] = level_at(np.ascontiguousarray(mean_dn[plane]), centre)
    return expected


def _planes(channels: int, mosaic: bool) -> Iterator[tuple[slice, slice, int]]:
    """Of an (H, W, C) image the pixels of each channel, or of each filter of a mosaic."""
    step = 2 if mosaic else 1
    for channel, row, column in product(range(channels), range(step), range(step)):
        yield slice(row, None, step), slice(column, None, step), channel


def smooth_terms(shape: tuple[int, ...]) -> NDArray[np.float64]:
    """(H W, 15) terms of smooth light in the pixels of an (H, W) picture: a surface of the fourth degree."""
    y, x = np.meshgrid(*map(_centres, shape), indexing="ij")
    return _terms(x.ravel(), y.ravel())


def _shading_of(plane: NDArray[np.float32], has_defects: bool = True) -> NDArray[np.float64]:
    """Coefficients of a surface of the fourth degree through the middle values of tiles.

    Vignetting is even in the radius up to r^6, a lamp a plane; the fourth degree holds both to a thousandth
    over the severities of lenses in use (EMVA 1288 release 4, 8.1, fits the second degree for lamps alone).
    """
    smooth = np.ascontiguousarray(plane, np.float32)
    if has_defects and min(plane.shape) > 4:
        smooth = np.asarray(cv2.medianBlur(smooth, 5), np.float32)
    tiles = _in_tiles(smooth)
    found, *_ = np.linalg.lstsq(smooth_terms(tiles.shape), tiles.ravel().astype(np.float64), rcond=1e-8)
    return np.asarray(found)


def _in_tiles(plane: NDArray[np.float32]) -> NDArray[np.float32]:
    """Means of square tiles of an (H, W) picture."""
    height, width = plane.shape
    step = max(1, max(height, width) // TILES)
    size = max(width // step, 1), max(height // step, 1)
    return np.asarray(cv2.resize(plane, size, interpolation=cv2.INTER_AREA), np.float32)


def _centres(count: int) -> NDArray[np.float64]:
    """(count,) middles of equal parts of the way from -1 to 1."""
    return (np.arange(count) + 0.5) / count * 2 - 1


def _terms(x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
    """(K, 15) powers of x and y up to the fourth degree in all."""
    return np.column_stack([x**i * y**j for i, j in _POWERS])
