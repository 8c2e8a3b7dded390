"""Materials as shading looks them up: stacks of textures and a table of figures."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_framework import Material
from tacos_framework.camera import LINEAR_OF_SRGB_BYTE

GREATEST_TEXTURE_PX = 1024
"""Larger textures are reduced to this edge [px]."""


def linear_of_bytes(encoded: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Linear reflectance of sRGB bytes (IEC 61966-2-1) [1].

    >>> linear_of_bytes(np.array([0, 188, 255], np.uint8)).round(3).tolist()
    [0.0, 0.503000020980835, 1.0]
    """
    return LINEAR_OF_SRGB_BYTE.astype(np.float32)[encoded]


def colour_levels(materials: Sequence[Material]) -> list[NDArray[np.uint8]]:
    """One layer per material that has a texture, after a white layer 0: square roots of linear reflectance.

    Eight bits hold square roots well and software OpenGL filters bytes fastest. Each mipmap level is averaged
    in linear light and encoded then, so that distant surfaces keep their mean reflectance.
    """
    images, _ = _distinct([material.texture for material in materials])
    linear = linear_of_bytes(np.arange(256, dtype=np.uint8))
    encoded = _square_roots(linear)

    def levels(image: NDArray[np.uint8]) -> list[NDArray[np.uint8]]:
        coarser = pyramid(linear.take(image))[1:]
        return [encoded.take(image), *map(_square_roots, coarser)]

    return _stack(np.full((1, 1, 3), 255, np.uint8), images, levels)


def normal_levels(materials: Sequence[Material]) -> list[NDArray[np.uint8]]:
    """One layer per normal map, after a flat layer 0."""
    images, _ = _distinct([material.normal_map for material in materials])

    def levels(image: NDArray[np.uint8]) -> list[NDArray[np.uint8]]:
        return [image, *(np.rint(level).astype(np.uint8) for level in pyramid(image.astype(np.float32))[1:])]

    return _stack(np.full((1, 1, 3), 128, np.uint8), images, levels)


def texture_layers(materials: Sequence[Material]) -> NDArray[np.int32]:
    """(materials, 2) int32: layer of each material in the colour and in the normal stack; 0 for none."""
    _, colour = _distinct([material.texture for material in materials])
    _, normal = _distinct([material.normal_map for material in materials])
    return np.array([colour, normal], np.int32).reshape(2, -1).T.copy()


def _distinct(images: Sequence[NDArray[np.uint8] | None]) -> tuple[list[NDArray[np.uint8]], list[int]]:
    """The images that differ, and for each one its place among them from 1, or 0 for none.

    Many materials are tints of one texture; they share its memory, and that of one layer.
    """
    place: dict[tuple[object, ...], int] = {}
    found: list[NDArray[np.uint8]] = []
    layers = []
    for image in images:
        if image is None:
            layers.append(0)
            continue
        memory = (image.__array_interface__["data"][0], image.shape, image.strides)
        if memory not in place:
            found.append(image)
            place[memory] = len(found)
        layers.append(place[memory])
    return found, layers


def material_table(materials: Sequence[Material], level: NDArray[np.int32]) -> NDArray[np.float32]:
    """(materials, 3, 4) float32: what `reflection.glsl` reads of each material.

    base colour; roughness, metallic and reflection `level`; emission [cd/m2].
    """
    table = np.zeros((max(len(materials), 1), 3, 4), np.float32)
    for row, material, number in zip(table, materials, level, strict=False):
        row[0, :3] = material.base_colour
        row[1, :3] = material.roughness, material.metallic, number
        row[2, :3] = material.emission_cd_m2
    return table


def pyramid(image: NDArray[np.float32]) -> list[NDArray[np.float32]]:
    """An image of (T, T, channels) and its means over two by two texels, down to a single one.

    >>> [level.ravel().tolist() for level in pyramid(np.float32([[[0], [1]], [[2], [5]]]))]
    [[0.0, 1.0, 2.0, 5.0], [2.0]]
    """
    levels = [image]
    while (edge := len(levels[-1]) // 2) >= 1:
        half = cv2.resize(levels[-1], (edge, edge), interpolation=cv2.INTER_AREA)
        levels.append(half.astype(np.float32, copy=False).reshape(edge, edge, -1))
    return levels


def _square_roots(linear: NDArray[np.float32]) -> NDArray[np.uint8]:
    return np.rint(np.sqrt(linear) * 255).astype(np.uint8)


def _stack(
    first: NDArray[np.uint8],
    images: Sequence[NDArray[np.uint8]],
    levels_of: Callable[[NDArray[np.uint8]], list[NDArray[np.uint8]]],
) -> list[NDArray[np.uint8]]:
    """Stack `first` and `images`, all scaled to the edge of the largest, each with its own mipmap levels."""
    edge = min(max((len(image) for image in images), default=1), GREATEST_TEXTURE_PX)
    depth = edge.bit_length()
    stacked = [np.empty((len(images) + 1, edge >> n, edge >> n, 4), np.uint8) for n in range(depth)]
    for layer, image in enumerate((first, *images)):
        levels = levels_of(image)
        # Smaller images are spread over the missing finer levels, larger ones leave theirs out.
        for number, place in enumerate(reversed(stacked)):
            size = place.shape[1]
            level = levels[max(len(levels) - 1 - number, 0)]
            if len(level) != size:
                level = cv2.resize(level, (size, size), interpolation=cv2.INTER_LINEAR).astype(np.uint8)
            cv2.cvtColor(level, cv2.COLOR_RGB2RGBA, dst=place[layer])
    return stacked
