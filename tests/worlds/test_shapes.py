"""Solids: closed, facing outwards, with unit normals."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tacos_worlds.indoor.furnishing.catalogue import BUILDERS
from tacos_worlds.kit.class_names import FURNITURE_CLASSES
from tacos_worlds.kit.finishes import draw_style
from tacos_worlds.kit.mesh import Mesh, shaded
from tacos_worlds.kit.shapes import (
    box,
    cushion,
    disc_stack,
    extruded,
    loft,
    slab,
    superellipse,
    tube,
)
from tests.worlds.solids import solid

edge = st.floats(0.05, 3.0)


def assert_solid(mesh: Mesh, volume_m3: float, rel: float) -> None:
    shape = solid(mesh)
    assert shape.is_watertight
    assert shape.volume == pytest.approx(volume_m3, rel=rel)


@given(x=edge, y=edge, z=edge)
@settings(max_examples=30, deadline=None)
def test_boxes_enclose_their_volume(x: float, y: float, z: float) -> None:
    assert_solid(slab((x, y, z)), x * y * z, 1e-6)
    assert_solid(box((x, y, z), bevel_m=0.002), x * y * z, 0.02)
    soft = solid(cushion((x, y, z), round_m=0.02, puff_m=0.01))
    assert soft.is_watertight
    assert soft.volume > 0.5 * x * y * z


def test_turned_and_swept_solids_enclose_their_volume() -> None:
    assert_solid(disc_stack([(0.5, 0), (0.5, 2)], sides=64), np.pi * 0.5**2 * 2, 0.01)
    assert_solid(tube([[0, 0, 0], [0, 0, 1], [0, 0, 3]], 0.1, sides=48), np.pi * 0.1**2 * 3, 0.01)
    assert_solid(extruded([[0, 0], [1, 0], [1, 1], [0, 1]], 2.0), 2.0, 1e-6)
    rings = [superellipse(1, 1, z, power=2.0, sides=64) for z in (0.0, 1.0)]
    assert_solid(loft(rings), np.pi, 0.01)


def test_normals_of_a_bevelled_box_stay_flat_on_its_faces() -> None:
    mesh = box((1, 1, 1), bevel_m=0.01)
    top = mesh.vertices_m[:, 2] > 0.999
    assert mesh.normals[top][:, 2].min() > 0.99


@pytest.mark.parametrize("kind", sorted(BUILDERS))
def test_furniture_is_whole(kind: str) -> None:
    class_name, builder = BUILDERS[kind]
    for seed in range(4):
        rng = np.random.default_rng(seed)
        made = builder(rng, draw_style(rng))
        assert made.class_name == class_name
        low, high = made.bounds_m
        assert (low + high)[:2] == pytest.approx([0, 0], abs=1e-6)
        assert low[2] == pytest.approx(0, abs=1e-6)
        assert sum(len(mesh.triangles) for mesh, _ in made.parts) < 3000
        for mesh, _ in made.parts:
            assert np.isfinite(mesh.vertices_m).all()
            assert np.linalg.norm(mesh.normals, axis=1) == pytest.approx(np.ones(len(mesh.normals)), abs=1e-6)
            corners = mesh.vertices_m[mesh.triangles]
            facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            agrees = np.einsum("ij,ij->i", facing, mesh.normals[mesh.triangles].mean(axis=1))
            assert (agrees > -1e-12).mean() > 0.98  # creases of thin leaves aside
            shape = solid(mesh)
            if shape.is_watertight:
                assert shape.volume > 0


@pytest.mark.parametrize("kind", sorted(k for k, (c, _) in BUILDERS.items() if c in FURNITURE_CLASSES))
def test_no_two_pieces_of_a_kind_are_alike(kind: str) -> None:
    sizes = set()
    for seed in range(4):
        rng = np.random.default_rng(seed)
        sizes.add(BUILDERS[kind][1](rng, draw_style(rng)).size_m)
    assert len(sizes) == 4


def test_a_slab_is_shaded_as_any_other_mesh() -> None:
    made = slab((0.3, 0.002, 1.2), (1.0, -2.0, 0.5))
    shaded_anew = shaded(made.vertices_m, made.triangles)
    for field in ("vertices_m", "normals", "uv_m", "triangles"):
        assert np.array_equal(getattr(made, field), getattr(shaded_anew, field)), field
