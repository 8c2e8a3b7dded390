"""Points of an image traced through effects that do nothing but move pixels."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates

from tacos_framework import (
    ContextMissing,
    EffectBase,
    ImageContext,
    ImageGeometry,
    calling,
    formation_order,
    moves_pixels,
    optional,
)
from tacos_framework.camera import Places
from tacos_framework.formation import PlacedEffect, in_image_units

LEAST_MAGNIFICATION = 0.05
"""Below it a lens images next to nothing: at a fold, and beyond."""

_HALF_PX = 0.5

Points = NDArray[np.float64]


def moving(effects: Sequence[PlacedEffect]) -> list[PlacedEffect]:
    return sorted((e for e in effects if moves_pixels(e.cls)), key=lambda e: formation_order(e.cls))


def traced(
    effects: Sequence[PlacedEffect], geometry: ImageGeometry, points_px: Points
) -> tuple[Points, NDArray[np.float64]]:
    """Places where a pinhole sees what effects move to points of the image, and their derivatives.

    - `effects`: Any; those that move pixels bear on it.
    - `points_px`: (K, 2) places in the image [px].

    Returns: (K, 2) places in the pinhole's image [px], and the inverse of their derivative (K, 2, 2): pixels
    of the image per pixel of the pinhole's.
    """
    steps = np.array([[0, 0], [_HALF_PX, 0], [-_HALF_PX, 0], [0, _HALF_PX], [0, -_HALF_PX]])
    around = (points_px[None] + steps[:, None]).reshape(-1, 2)
    for effect in reversed(moving(effects)):
        around = _through(effect, geometry, around)
    here, right, left, below, above = around.reshape(5, -1, 2)
    derivative = np.stack([right - left, below - above], axis=-1) / (2 * _HALF_PX)
    u, magnification, v = np.linalg.svd(derivative)
    inverse = np.einsum("kji,kj,klj->kil", v, 1 / np.maximum(magnification, LEAST_MAGNIFICATION), u)
    return here, inverse


def _through(placed: PlacedEffect, geometry: ImageGeometry, points_px: Points) -> Points:
    """Sources of points through one effect: exact if it says so, else between the pixels of its map."""
    if not callable(optional(placed.cls, EffectBase, "source_at")):
        source = source_of(placed, geometry)
        return points_px if source is None else _looked_up(source, points_px)
    nothing = ImageContext()
    with calling(placed.use, doing="source_at"):
        effect = placed.cls(in_image_units(placed.config, placed.use, geometry, nothing))
        return np.column_stack(effect.source_at(*points_px.T, geometry=geometry))


def source_of(placed: PlacedEffect, geometry: ImageGeometry) -> Places | None:
    """Source of each pixel through an effect that does nothing but move pixels, and needs no circumstances.

    None for all others, as for those that go by motion or depth.
    """
    if not moves_pixels(placed.cls):
        return None
    nothing = ImageContext()
    with calling(placed.use, doing="source"):
        effect = placed.cls(in_image_units(placed.config, placed.use, geometry, nothing))
        try:
            places: Places | None = effect.source(geometry=geometry, context=nothing, frames=1)
        except ContextMissing:
            return None
        if places is None:
            return None
        x, y = (np.reshape(part, (geometry.height_px, geometry.width_px)) for part in places)
    return x, y


def _looked_up(source: Places, points_px: Points) -> Points:
    """Sources of pixels at points, between the whole pixels that `source` gives."""
    return np.column_stack(
        [map_coordinates(part, points_px[:, ::-1].T, order=1, mode="nearest") for part in source]
    )
