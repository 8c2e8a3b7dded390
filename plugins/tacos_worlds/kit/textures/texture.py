"""A texture: colours, and heights for its normal map."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray


@dataclass(frozen=True, eq=False)
class Texture:
    """A square image that tiles."""

    colour: NDArray[np.uint8]  # (T, T, 3) uint8 sRGB
    size_m: float  # edge of one tile [m]
    normal_map: NDArray[np.uint8] | None = None  # (T, T, 3) uint8 tangent-space normals, or None


def texture(colour: ArrayLike, size_m: float, *, height_m: NDArray[np.float64] | None = None) -> Texture:
    """A texture from (T, T, 3) or grey (T, T) sRGB values in 0..1 and, optionally, (T, T) heights [m].

    Row 0 of the image lies at v = 0 and v grows with the row index.
    """
    image = np.clip(np.asarray(colour, dtype=np.float64), 0, 1)
    image *= 255
    bytes_ = np.rint(image, out=image).astype(np.uint8)
    if bytes_.ndim == 2:
        bytes_ = np.stack([bytes_, bytes_, bytes_], axis=2)
    normal_map = None if height_m is None else _normal_map(height_m, size_m / len(image))
    return Texture(np.ascontiguousarray(bytes_), size_m, normal_map)


def _normal_map(height_m: NDArray[np.float64], texel_m: float) -> NDArray[np.uint8]:
    slope_u = (np.roll(height_m, -1, axis=1) - np.roll(height_m, 1, axis=1)) / (2 * texel_m)
    slope_v = (np.roll(height_m, -1, axis=0) - np.roll(height_m, 1, axis=0)) / (2 * texel_m)
    length = np.sqrt(slope_u * slope_u + slope_v * slope_v + 1)
    normal = (-slope_u / length, -slope_v / length, 1 / length)
    return np.stack([np.rint(part * 127 + 128).astype(np.uint8) for part in normal], axis=2)


def blend(low: ArrayLike, high: ArrayLike, weight: NDArray[np.float64]) -> NDArray[np.float64]:
    """Colours between two, by (T, T) weights."""
    first, second = np.asarray(low, dtype=np.float64), np.asarray(high, dtype=np.float64)
    colours = np.empty((*weight.shape, 3))
    for channel in range(3):  # numpy takes many times as long over rows of three numbers
        start = first[..., channel]
        colours[..., channel] = start + (second[..., channel] - start) * weight
    return colours


def texels_near(place: float, reach: float, size: int) -> NDArray[np.int64]:
    """Rows or columns of a texture that tiles, within a reach of a place; both are shares of its edge."""
    first, last = math.floor((place - reach) * size), math.ceil((place + reach) * size)
    return np.arange(first, last + 1) % size
