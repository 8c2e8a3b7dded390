"""Splitting large triangles changes no surface."""

from __future__ import annotations

import numpy as np
import pytest
from small_worlds import matte, quad, room, world

from tacos_framework.values import Light
from tacos_plugins.lighting import LightTransport
from tacos_plugins.lighting.refinement import refined


def areas_m2(part):
    corners = part.vertices_m[part.triangles].astype(np.float64)
    return np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2


def test_edges_are_short_and_the_surface_is_the_same():
    whole = quad((1.0, 2.0, 0.5), (2.0, 0.5, 0.0), (0.0, 0.3, 0.7))
    (split,) = refined(world([whole]), 0.5).parts
    corners = split.vertices_m[split.triangles]
    assert np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max() <= 0.5
    assert areas_m2(split).sum() == pytest.approx(areas_m2(whole).sum(), rel=1e-5)
    np.testing.assert_allclose((split.vertices_m - whole.vertices_m[0]) @ whole.normals[0], 0, atol=1e-5)
    faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (faces @ whole.normals[0] > 0).all()


def test_vertices_keep_their_place_and_small_triangles_are_left():
    whole, small = quad((0, 0, 0), (2, 0, 0), (0, 2, 0)), quad((0, 0, 1), (0.1, 0, 0), (0, 0.1, 0))
    split, same = refined(world([whole, small]), 0.5).parts
    np.testing.assert_array_equal(split.vertices_m[:4], whole.vertices_m)
    np.testing.assert_array_equal(split.uv_m[:4], whole.uv_m)
    assert same is small


def test_walls_of_two_triangles_reflect_what_they_really_get():
    # A cube of reflectance r around a small lamp: the mean illuminance is F / A / (1 - r), of which the share
    # r has been reflected. Corners alone get far less than the middle of a wall.
    lamp = Light(np.zeros(3), np.full(3, 600.0), radius_m=0.02)
    cube = world(room((-1, -1, -1), (1, 1, 1)), [matte(0.6)], [lamp], indirect_lux=None)
    steps = (np.arange(8) + 0.5) / 4 - 1
    points = np.stack([*np.meshgrid(steps, steps), np.full((8, 8), -1.0)], axis=-1).reshape(-1, 3)
    up = np.tile(np.array([0, 0, 1], np.float32), (64, 1))
    mean = LightTransport(cube).indirect_lux(points.astype(np.float32), up).mean()
    assert mean == pytest.approx(0.6 * 600.0 / 24 / (1 - 0.6), rel=0.1)
