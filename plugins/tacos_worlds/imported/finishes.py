"""Skins of files as materials of worlds: square textures, as large as the memory given to them allows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_framework import Material
from tacos_worlds.kit.models.model import Skin

_BYTES_PER_TEXEL = 4 * 4 / 3
"""Of a layer with its coarser levels, as drivers keep three channels in four [bytes]."""
_LEAST_PX, _MOST_PX = 64, 8192


def texture_edge_px(layers: int, memory_mb: float) -> int:
    """The edge of square textures of which so many fit into the memory: a power of two.

    All layers of a stack are as large as its largest.

    >>> texture_edge_px(4, 512), texture_edge_px(60, 512)
    (4096, 1024)
    """
    most = (memory_mb * 2**20 / _BYTES_PER_TEXEL / max(layers, 1)) ** 0.5
    edge = _LEAST_PX
    while 2 * edge <= min(most, _MOST_PX):
        edge *= 2
    return edge


def materials_of(
    skins: Sequence[Skin],
    atlases: Mapping[int, NDArray[np.uint8]],
    *,
    memory_mb: float,
    emission_scale: float,
) -> tuple[Material, ...]:
    """One material a skin.

    - `atlases`: by index of a skin, the painted colours of its vertices in place of a texture.
    - `memory_mb`: for all textures together [MB].
    - `emission_scale`: luminance for one unit of emission in the file [cd/m2].
    """
    images = {id(image) for skin in skins for image in (skin.texture, skin.normal_map) if image is not None}
    edge_px = texture_edge_px(len(images) + len(atlases), memory_mb)
    squares: dict[int, NDArray[np.uint8]] = {}

    def square(image: NDArray[np.uint8] | None) -> NDArray[np.uint8] | None:
        if image is None:
            return None
        if id(image) not in squares:
            squares[id(image)] = squared(image, edge_px)
        return squares[id(image)]

    return tuple(
        Material(
            name=skin.name or f"material {index}",
            base_colour=skin.base_colour.astype(np.float32),
            texture=atlases[index] if index in atlases else square(skin.texture),
            texture_size_m=1.0,
            normal_map=square(skin.normal_map),
            roughness=skin.roughness,
            metallic=skin.metallic,
            emission_cd_m2=(skin.emission * emission_scale).astype(np.float32),
            unlit=skin.unlit,
        )
        for index, skin in enumerate(skins)
    )


def squared(image: NDArray[np.uint8], most_px: int) -> NDArray[np.uint8]:
    """An image as a square whose edge is a power of two, no longer than `most_px`."""
    longest = max(image.shape[:2])
    edge = 1
    while edge < longest and 2 * edge <= most_px:
        edge *= 2
    if image.shape[:2] == (edge, edge):
        return np.ascontiguousarray(image)
    smaller = edge < longest
    way = cv2.INTER_AREA if smaller else cv2.INTER_LINEAR
    resized = cv2.resize(np.ascontiguousarray(image), (edge, edge), interpolation=way)
    return np.asarray(resized, np.uint8)
