"""Fences, leaves and grilles: surfaces cut to where their texture is opaque.

Holes are holes for all that follows: images, depth, ids, light and where one can walk.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_worlds.kit.models.mask_outlines import outlines
from tacos_worlds.kit.models.model import Model, Skin, Surface
from tacos_worlds.kit.models.uv_clipping import cut

_LEAST_OPACITY = 0.5
"""Clearer surfaces are left out: a pane of glass, drawn as a wall, would shut the light out [1]."""
_MOST_TILES = 20_000
"""A mask repeated more often on one surface is finer than can be seen: it is there as a whole or not [1]."""
_FINEST_PX, _COARSEST_PX = 512, 4
_NOTABLE, _FEW = 0.3, 0.02
"""Share of a mask by which the area drawn may differ, and what counts as nothing of it [1]."""
_FAR = 1e6
"""Beyond any texture coordinate [tiles]."""
_ROUNDING = 1e-6


def without_clear(model: Model, *, solid: bool = False) -> Model:
    """The model without the surfaces that one sees through; those, and half clear ones, are told.

    `solid`: keep them all, opaque.
    """
    used = [model.skins[surface.skin] for surface in model.surfaces]
    clear = sorted({skin.name for skin in used if skin.opacity < _LEAST_OPACITY})
    hazy = sorted({skin.name for skin in used if _LEAST_OPACITY <= skin.opacity < 1})
    kept = [
        s for s, skin in zip(model.surfaces, used, strict=True) if solid or skin.opacity >= _LEAST_OPACITY
    ]
    left_out = "clear surfaces are left out: light, image and depth pass them"
    effects = (
        (clear, "clear surfaces are drawn opaque" if solid else left_out),
        (hazy, "half clear surfaces are drawn opaque"),
    )
    notes = (
        f"{', '.join(name or 'no name' for name in names[:5])}: {effect}"
        for names, effect in effects
        if names
    )
    return replace(model, surfaces=tuple(kept), notes=(*model.notes, *notes))


def cut_out(model: Model, most_triangles: int = 200_000) -> Model:
    """The model with the holes of its masks, and with textures that end at their edges held there.

    Masks whose outlines take more triangles are cut more coarsely, which is told where it changes the area.
    """
    with_holes = sum(model.skins[s.skin].mask is not None and s.uv is not None for s in model.surfaces)
    most = most_triangles // max(with_holes, 1)
    notes: dict[str, None] = {}
    surfaces = []
    for surface in model.surfaces:
        skin = model.skins[surface.skin]
        made, coarse = _cut(surface, skin, most)
        surfaces.append(made)
        if coarse and skin.mask is not None and (before := _area(surface)) > 0:
            drawn, there = _area(made) / before, float((skin.mask >= 255 * skin.cutoff).mean())
            if abs(drawn - there) > _NOTABLE * max(there, 1 - there):
                what = "left out" if drawn < _FEW else "drawn solid" if drawn > 1 - _FEW else "cut coarsely"
                notes[
                    f"{skin.name or 'no name'}: its mask repeats too finely to be cut out, and is {what}"
                ] = None
    return replace(model, surfaces=tuple(surfaces), notes=(*model.notes, *notes))


def _area(surface: Surface) -> float:
    a, b, c = (surface.vertices[surface.triangles[:, corner]] for corner in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())


def _cut(surface: Surface, skin: Skin, most: int) -> tuple[Surface, bool]:
    """The surface that is left, and whether its mask was too fine to be cut as it is."""
    if surface.uv is None or not len(surface.triangles) or not np.abs(surface.uv).max() < _FAR:
        return surface, False
    if any(skin.clamped):
        surface = _held(surface, skin)
    return (surface, False) if skin.mask is None else _perforated(surface, skin, most)


def _held(surface: Surface, skin: Skin) -> Surface:
    """Texture coordinates beyond an edge that does not repeat, held at it; triangles cut where it lies.

    They are held at the middle of the outermost texels, beyond which samplers blend with the other edge.
    """
    assert surface.uv is not None
    low, high = surface.uv.min(axis=0), surface.uv.max(axis=0)
    beyond = (low < -_ROUNDING) | (high > 1 + _ROUNDING)
    held = np.array(skin.clamped) & beyond
    if not held.any():
        return surface
    size = np.full(2, np.inf) if skin.texture is None else np.array(skin.texture.shape[1::-1], np.float64)
    least = np.where(held, 0.5 / size, -_FAR)
    most = np.where(held, 1 - least, _FAR)
    bands = [
        [(-_FAR, least[axis]), (least[axis], most[axis]), (most[axis], _FAR)]
        if held[axis]
        else [(-_FAR, _FAR)]
        for axis in (0, 1)
    ]
    fields = np.array([[(a, c), (b, c), (b, d), (a, d)] for a, b in bands[0] for c, d in bands[1]])
    sound = _has_area(surface)
    surface = cut(surface, np.repeat(sound, len(fields)), np.tile(fields, (len(sound), 1, 1)))
    return replace(surface, uv=None if surface.uv is None else np.clip(surface.uv, least, most))


def _perforated(surface: Surface, skin: Skin, most: int) -> tuple[Surface, bool]:
    assert surface.uv is not None
    assert skin.mask is not None
    sound = _has_area(surface)
    corners = surface.uv[surface.triangles[sound]]
    if float(np.ptp(corners, axis=1).prod(axis=1).sum()) > _MOST_TILES:
        whole = float(skin.mask.mean()) / 255 >= skin.cutoff
        return (surface if whole else replace(surface, triangles=np.zeros((0, 3), np.int64))), True
    tiles = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])).sum() / 2
    polygons, coarse = _outlines_within(skin, float(most), float(tiles) + 0.02 * len(sound))
    owner, placed = _placed(corners, polygons, skin.clamped)
    if not len(owner):
        return replace(surface, triangles=np.zeros((0, 3), np.int64)), coarse
    return cut(surface, sound[owner], placed), coarse


def _has_area(surface: Surface) -> NDArray[np.intp]:
    """The triangles that have an extent in the texture."""
    assert surface.uv is not None
    corners = surface.uv[surface.triangles]
    return np.flatnonzero(np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) > 1e-14)


def _outlines_within(skin: Skin, most: float, tiles: float) -> tuple[NDArray[np.float64], bool]:
    """Outlines as fine as the triangles they give allow, and whether that is coarser than the mask."""
    assert skin.mask is not None
    edge = finest = min(max(skin.mask.shape), _FINEST_PX)
    while True:
        shrunk = skin.mask.astype(np.float32)
        if edge < max(shrunk.shape):
            rows, columns = (max(1, side * edge // max(skin.mask.shape)) for side in shrunk.shape)
            shrunk = np.asarray(cv2.resize(shrunk, (columns, rows), interpolation=cv2.INTER_AREA), np.float32)
        found = outlines(shrunk.astype(np.float64) / 255 - skin.cutoff, skin.clamped)
        if 2 * len(found) * tiles <= most or edge <= _COARSEST_PX:
            return found, edge < finest
        edge //= 2


def _placed(
    corners: NDArray[np.float64], polygons: NDArray[np.float64], clamped: Sequence[bool]
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Triangles that may meet outlines of tiles: (N,) triangles and (N, K, 2) polygons there."""
    lower, upper = polygons.min(axis=1), polygons.max(axis=1)
    owners, placed = [np.zeros(0, np.int64)], [polygons[:0]]
    for index, triangle in enumerate(corners):
        low, high = triangle.min(axis=0), triangle.max(axis=0)
        # Outlines of a tile that repeats begin half a texel inside it and end as far beyond.
        ranges = [
            [0] if clamped[axis] else range(int(np.floor(low[axis])) - 1, int(np.floor(high[axis])) + 1)
            for axis in (0, 1)
        ]
        shifts = np.array([(i, j) for i in ranges[0] for j in ranges[1]], np.float64)
        near = (lower + shifts[:, None] < high).all(axis=2) & (upper + shifts[:, None] > low).all(axis=2)
        shift, which = np.nonzero(near)
        owners.append(np.full(len(which), index))
        placed.append(polygons[which] + shifts[shift][:, None])
    return np.concatenate(owners), np.concatenate(placed)
