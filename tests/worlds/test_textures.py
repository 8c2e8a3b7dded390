"""Textures: they tile, and they hold detail."""

from __future__ import annotations

import numpy as np
import pytest

from tacos_worlds.kit.finishes import TEXTURES
from tacos_worlds.kit.textures.texture import Texture

PICTURES = {"abstract", "landscape", "photograph", "desktop", "view_outside"}
"""Seen once each, edge to edge, so they need not tile."""


@pytest.fixture(scope="module")
def made() -> dict[str, Texture]:
    return {
        name: synthesise(np.random.default_rng(3), min(size, 256))
        for name, (synthesise, size) in TEXTURES.items()
    }


@pytest.mark.parametrize("name", sorted(set(TEXTURES) - PICTURES))
def test_no_seam_stands_out_where_tiles_meet(made: dict[str, Texture], name: str) -> None:
    colour = made[name].colour.astype(float)
    for axis in (0, 1):
        steps = np.abs(np.diff(colour, axis=axis, append=np.take(colour, [0], axis=axis))).mean(
            axis=(1 - axis, 2)
        )
        # Joints and stripes are steps of their own: the seam must not exceed the largest of them.
        assert steps[-1] <= 1.25 * steps[:-1].max()


@pytest.mark.parametrize("name", sorted(TEXTURES))
def test_detail_at_fine_and_coarse_scales(made: dict[str, Texture], name: str) -> None:
    grey = made[name].colour.astype(float).mean(axis=2)
    coarse = grey.reshape(16, len(grey) // 16, 16, -1).mean(axis=(1, 3))
    fine = grey - np.kron(coarse, np.ones((len(grey) // 16, len(grey) // 16)))
    assert fine.std() > 0.8
    assert coarse.std() > 0.3


@pytest.mark.parametrize("name", sorted(TEXTURES))
def test_size_is_a_power_of_two_and_normals_have_unit_length(made: dict[str, Texture], name: str) -> None:
    size = len(made[name].colour)
    assert size & (size - 1) == 0
    normals = made[name].normal_map
    if normals is not None:
        length = np.linalg.norm((normals.astype(float) - 128) / 127, axis=2)
        assert length == pytest.approx(np.ones((size, size)), abs=0.02)
        assert (normals[..., 2] > 128).all()
