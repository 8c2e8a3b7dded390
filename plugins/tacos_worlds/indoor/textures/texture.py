"""A texture: colours, and heights for its normal map."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray


@dataclass(frozen=True, eq=False)
class Texture:
    """A square image that tiles.

    Parameters
    ----------
    colour
        (T, T, 3) uint8 sRGB.
    size_m
        Edge of one tile [m].
    normal_map
        (T, T, 3) uint8 tangent-space normals, or None.
    """

    colour: NDArray[np.uint8]
    size_m: float
    normal_map: NDArray[np.uint8] | None = None


def texture(colour: ArrayLike, size_m: float, *, height_m: NDArray[np.float64] | None = None) -> Texture:
    """A texture from (T, T, 3) sRGB values in 0..1 and, optionally, (T, T) heights [m].

    Row 0 of the image lies at v = 0 and v grows with the row index.
    """
    image = np.asarray(colour, dtype=np.float64)
    bytes_ = np.rint(np.clip(image, 0, 1) * 255).astype(np.uint8)
    normal_map = None if height_m is None else _normal_map(height_m, size_m / len(image))
    return Texture(np.ascontiguousarray(bytes_), size_m, normal_map)


def _normal_map(height_m: NDArray[np.float64], texel_m: float) -> NDArray[np.uint8]:
    slope_u = (np.roll(height_m, -1, axis=1) - np.roll(height_m, 1, axis=1)) / (2 * texel_m)
    slope_v = (np.roll(height_m, -1, axis=0) - np.roll(height_m, 1, axis=0)) / (2 * texel_m)
    normals = np.stack([-slope_u, -slope_v, np.ones_like(slope_u)], axis=2)
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    return np.rint(normals * 127 + 128).astype(np.uint8)


def blend(low: ArrayLike, high: ArrayLike, weight: NDArray[np.float64]) -> NDArray[np.float64]:
    """Colours between two, by (T, T) weights."""
    first, second = np.asarray(low, dtype=np.float64), np.asarray(high, dtype=np.float64)
    return first + (second - first) * weight[..., None]
