"""Materials as OpenGL sees them: stacks of textures and a table of figures."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import moderngl
import numpy as np
from numpy.typing import NDArray

from tacos_framework.values import Material
from tacos_plugins.renderers.moderngl.context import describe_gl, write_level

GREATEST_TEXTURE_PX = 1024
"""Larger textures are reduced to this edge [px]."""

ANISOTROPY = 16.0
"""Samples along the longer side of a pixel's footprint, where the hardware takes them [1]."""


def linear_from_srgb(encoded: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Linear reflectance of sRGB bytes (IEC 61966-2-1) [1].

    Examples
    --------
    >>> linear_from_srgb(np.array([0, 188, 255], np.uint8)).round(3).tolist()
    [0.0, 0.503000020980835, 1.0]
    """
    code = np.arange(256) / 255
    linear = np.where(code <= 0.04045, code / 12.92, ((code + 0.055) / 1.055) ** 2.4)
    return linear.astype(np.float32)[encoded]


def colour_stack(context: moderngl.Context, materials: Sequence[Material]) -> moderngl.TextureArray:
    """One layer per material that has a texture, after a white layer 0: square roots of linear reflectance.

    Eight bits hold square roots well and software OpenGL filters bytes fastest. Each mipmap level is averaged
    in linear light and encoded then, so that distant surfaces keep their mean reflectance.
    """
    images = [material.texture for material in materials if material.texture is not None]
    edge = common_edge(images)
    linear = np.ones((len(images) + 1, edge, edge, 4), np.float32)
    for layer, image in zip(linear[1:], images, strict=True):
        layer[..., :3] = _resized(linear_from_srgb(image), edge)
    levels = [np.rint(np.sqrt(level) * 255).astype(np.uint8) for level in mean_pyramid(linear)]
    return _upload(context, levels)


def normal_stack(context: moderngl.Context, materials: Sequence[Material]) -> moderngl.TextureArray:
    """One layer per material that has a normal map, after a flat layer 0."""
    images = [material.normal_map for material in materials if material.normal_map is not None]
    edge = common_edge(images)
    tilt = np.full((len(images) + 1, edge, edge, 4), 128, np.float32)
    for layer, image in zip(tilt[1:], images, strict=True):
        layer[..., :3] = _resized(image, edge)
    return _upload(context, [np.rint(level).astype(np.uint8) for level in mean_pyramid(tilt)])


def texture_layers(materials: Sequence[Material]) -> NDArray[np.int32]:
    """(materials, 2) int32: layer of each material in the colour and in the normal stack; 0 for none."""
    has = np.array([[m.texture is not None, m.normal_map is not None] for m in materials], dtype=bool)
    has = has.reshape(-1, 2)
    return np.where(has, np.cumsum(has, axis=0), 0).astype(np.int32)


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


def mean_pyramid(stack: NDArray[np.float32]) -> list[NDArray[np.float32]]:
    """Levels of (layers, T, T, channels) images, each the means of two by two texels of the one before.

    Examples
    --------
    >>> [level.ravel().tolist() for level in mean_pyramid(np.float32([[[[0], [1]], [[2], [5]]]]))]
    [[0.0, 1.0, 2.0, 5.0], [2.0]]
    """
    levels = [stack]
    while (edge := levels[-1].shape[1] // 2) >= 1:
        layers, _, _, channels = stack.shape
        levels.append(levels[-1].reshape(layers, edge, 2, edge, 2, channels).mean(axis=(2, 4)))
    return levels


def common_edge(images: Sequence[NDArray[np.uint8]]) -> int:
    """The edge all layers of a stack get [px]."""
    return min(max((len(image) for image in images), default=1), GREATEST_TEXTURE_PX)


def _resized(image: NDArray[np.generic], edge: int) -> NDArray[np.generic]:
    if len(image) == edge:
        return image
    shrinks = len(image) > edge
    return cv2.resize(image, (edge, edge), interpolation=cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR)


def _upload(context: moderngl.Context, levels: Sequence[NDArray[np.uint8]]) -> moderngl.TextureArray:
    layers, edge = levels[0].shape[:2]
    texture = context.texture_array((edge, edge, layers), 4, levels[0].tobytes())
    texture.repeat_x = texture.repeat_y = True
    texture.build_mipmaps()  # makes room for the levels
    for number, level in enumerate(levels[1:], start=1):
        write_level(texture, number, level)
    in_software = describe_gl().is_software  # where blending two levels costs half as much again per pixel
    between_levels = moderngl.LINEAR_MIPMAP_NEAREST if in_software else moderngl.LINEAR_MIPMAP_LINEAR
    texture.filter = (between_levels, moderngl.LINEAR)
    if not in_software and context.max_anisotropy > 1:
        texture.anisotropy = min(ANISOTROPY, context.max_anisotropy)
    return texture
