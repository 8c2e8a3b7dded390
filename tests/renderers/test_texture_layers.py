"""Materials that are tints of one texture share its layer."""

from __future__ import annotations

import numpy as np

from tacos_framework.values import Material
from tacos_plugins.renderers.light.textures import texture_layers


def material(texture: np.ndarray | None, normal_map: np.ndarray | None = None, tint: float = 1.0) -> Material:
    return Material("m", np.full(3, tint, np.float32), texture=texture, normal_map=normal_map)


def test_tints_share_a_layer_and_other_views_of_the_same_memory_do_not() -> None:
    brick, bumps = np.full((8, 8, 3), 90, np.uint8), np.full((8, 8, 3), 128, np.uint8)
    wood = np.full((8, 8, 3), 60, np.uint8)
    materials = [
        material(brick, bumps),
        material(None),
        material(brick, bumps, tint=0.5),
        material(wood),
        material(brick[:, :, ::-1]),
    ]
    assert texture_layers(materials).tolist() == [[1, 1], [0, 0], [1, 1], [2, 0], [3, 0]]


def test_no_materials_have_no_layers() -> None:
    assert texture_layers([]).shape == (0, 2)
