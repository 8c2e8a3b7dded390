"""Surfaces whose colour was photographed with its light."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tacos_framework import Light, Material, MeshPart, Object, World
from tacos_plugins.renderers.light.baked_mesh import light_world

COLOUR = np.array([0.5, 0.2, 0.8], np.float32)
QUAD = np.array([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]], np.float32)
TWO = np.array([[0, 1, 2], [0, 2, 3]], np.int32)


def quad(vertices_m: np.ndarray) -> MeshPart:
    up = np.tile(np.float32([0, 0, 1]), (4, 1))
    return MeshPart(vertices_m, up, vertices_m[:, :2], TWO, material=0, object_id=0)


def sent_back(*, unlit: bool, lux: float, flux_lm: float) -> np.ndarray:
    """(N, 3) luminance all over a sheet under a lamp, half of it in the shade of another [cd/m2]."""
    parts = (quad(QUAD), quad(QUAD * np.float32([0.5, 1, 1]) + np.float32([0, 0, 0.4])))
    lamp = Light(np.array([1, 1, 2], np.float32), np.full(3, flux_lm, np.float32))
    photo = Material("photo", COLOUR, unlit=unlit)
    world = World("w", parts, (photo,), (Object("b", "b"),), ("b",), lights=(lamp,))
    baked = light_world(world, tuple(np.full((4, 3), lux, np.float32) for _ in parts), 0.1)
    everywhere = [baked.vertex_light.luminance_cd_m2, baked.light_map[..., :3].reshape(-1, 3)]
    lit = np.concatenate(everywhere)
    return lit[lit.any(axis=1)]


@settings(max_examples=8, deadline=None)
@given(lux=st.floats(1, 5000), flux_lm=st.floats(0, 1e5))
def test_neither_lamps_nor_shadows_change_an_unlit_surface(lux: float, flux_lm: float) -> None:
    found = sent_back(unlit=True, lux=lux, flux_lm=flux_lm)
    assert len(found)
    np.testing.assert_allclose(found, np.tile(COLOUR * lux / np.pi, (len(found), 1)), rtol=1e-4)


def test_they_do_change_another() -> None:
    found = sent_back(unlit=False, lux=100, flux_lm=1e4)
    assert found[:, 0].max() > 3 * found[:, 0].min()
    assert found[:, 0].max() != pytest.approx(COLOUR[0] * 100 / np.pi, rel=0.1)
