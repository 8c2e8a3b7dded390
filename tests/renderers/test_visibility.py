"""Surfaces drawn without OpenGL, beside planes met by rays one at a time."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tacos_plugins.renderers.software.lanes import with_lanes
from tacos_plugins.renderers.software.projected import project
from tacos_plugins.renderers.software.visibility import look

SHAPE = (40, 50)
NEAR_M = 0.1
PIXEL = np.array([[30.0, 0.0, 24.3, 0.0], [0.0, 30.0, 19.7, 0.0], [0.0, 0.0, 1.0, 0.0]])


def drawn(corners, closed=False):
    """(H, W) depth and triangle number, from 1, of (T, 3, 3) corners in front of a camera."""
    with np.errstate(divide="ignore"):
        inverse, number = drawn_rows(corners, 0, SHAPE[0], closed)
        return 1 / inverse, number


def drawn_rows(corners, first_row, rows, closed=False):
    """Inverse depth and triangle number of some rows, each triangle a run of its own."""
    corners = np.asarray(corners, np.float32)
    count = len(corners)
    shape = (rows, SHAPE[1])
    inverse, number = with_lanes(shape, np.float32), with_lanes(shape, np.int32)
    vertices = np.arange(3 * count, dtype=np.int32)
    runs = np.column_stack([np.arange(count), np.ones(count, np.int64)])
    mesh = (corners.reshape(-1, 3), vertices.reshape(-1, 3))
    look([project(*mesh, runs, PIXEL, SHAPE, NEAR_M, closed)], inverse, number, first_row)
    return inverse, number


def met(corners):
    """The same by the ray of each pixel and the plane of each triangle; and pixels too near an edge."""
    row, column = np.indices(SHAPE)
    ray = np.stack([(column - 24.3) / 30, (row - 19.7) / 30, np.ones(SHAPE)], axis=-1)
    depth, number, unsure = np.full(SHAPE, np.inf), np.zeros(SHAPE, int), np.zeros(SHAPE, bool)
    for index, (a, b, c) in enumerate(np.asarray(corners, np.float64), start=1):
        normal = np.cross(b - a, c - a)
        edge_on = np.abs(ray @ normal) < 1e-3 * np.linalg.norm(normal)  # a hair's breadth is metres of depth
        with np.errstate(divide="ignore", invalid="ignore"):
            z = (normal @ a) / (ray @ normal)
            point = ray * z[..., None]
            edges = [
                np.cross(q - p, point - p) @ normal / (normal @ normal) for p, q in ((a, b), (b, c), (c, a))
            ]
        inside = np.min(edges, axis=0)
        unsure |= edge_on | ~np.isfinite(z) | (np.abs(inside) < 0.02) | (np.abs(z - NEAR_M) < 1e-2)
        hit = (inside > 0) & (z >= NEAR_M)
        unsure |= hit & (np.abs(z - depth) < 1e-3)
        nearer = hit & (z < depth)
        depth[nearer], number[nearer] = z[nearer], index
    return depth, number, unsure


place = st.tuples(*[st.floats(-3, 3), st.floats(-3, 3), st.floats(-1, 5)])


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(place, place, place), min_size=1, max_size=5))
def test_nearest_surface_and_depth_are_those_that_rays_meet(corners):
    corners = np.array(corners)
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    corners = corners[area > 0.5]
    if len(corners) == 0:
        return
    depth, number = drawn(corners)
    expected_depth, expected, unsure = met(corners)
    sure = ~unsure
    np.testing.assert_array_equal(number[sure], expected[sure])
    np.testing.assert_allclose(depth[sure], expected_depth[sure], rtol=2e-3)


@settings(deadline=None)
@given(st.lists(st.tuples(place, place, place), min_size=1, max_size=8), st.integers(1, SHAPE[0] - 1))
def test_bands_of_rows_are_the_same_bits_as_the_whole(corners, cut):
    whole = drawn_rows(corners, 0, SHAPE[0])
    bands = zip(drawn_rows(corners, 0, cut), drawn_rows(corners, cut, SHAPE[0] - cut), strict=True)
    for one, (over, under) in zip(whole, bands, strict=True):
        np.testing.assert_array_equal(one, np.vstack([over, under]))


@given(st.permutations(range(1, 6)))
def test_what_is_hidden_and_passed_over_would_not_have_shown(depths):
    # Walls one behind another, wider than the image, so that each fills whole rows: the order cannot matter.
    wall = np.array([(-9, -9, 1), (0, 18, 1), (9, -9, 1.0)])
    depth, number = drawn([wall * z for z in depths])
    np.testing.assert_allclose(depth, 1.0, rtol=1e-6)
    assert (number == depths.index(1) + 1).all()


@given(st.lists(st.tuples(st.integers(0, 200), st.integers(0, 160)), min_size=1, max_size=1))
def test_triangles_about_a_point_cover_each_sample_once(middle):
    # Corners on sample places and between them: samples on shared edges belong to exactly one triangle.
    (x, y), rim = middle[0], [(-8, -8), (216, -8), (216, 176), (-8, 176)]
    to_camera = np.linalg.inv(PIXEL[:, :3])
    fan = [[to_camera @ (u / 4, v / 4, 1) for u, v in ((x, y), rim[i], rim[(i + 1) % 4])] for i in range(4)]
    covered = sum((drawn([part])[1] > 0).astype(int) for part in fan)
    assert (covered == 1).all()


def test_more_triangles_than_there_was_room_for_at_first_are_all_drawn():
    # One about each pixel's centre, which covers that and no other.
    column, row = (grid.reshape(-1) for grid in np.meshgrid(np.arange(50.0), np.arange(40.0)))
    at = np.stack([column, row, np.ones_like(row)], axis=-1)
    corners = at[:, None] + np.array([(-0.4, -0.4, 0), (0.5, 0, 0), (-0.4, 0.5, 0)])
    _, number = drawn(corners @ np.linalg.inv(PIXEL[:, :3]).T)
    np.testing.assert_array_equal(number, np.arange(1, 2001).reshape(SHAPE))


@pytest.mark.parametrize("closed", [False, True])
def test_backs_are_drawn_unless_the_part_is_closed(closed):
    facing = np.array(
        [[(-1, -1, 2.0), (-1, 1, 2.0), (1, 0, 2.0)]]
    )  # counter-clockwise as seen from the camera
    assert drawn(facing, closed)[1].any()
    assert drawn(facing[:, ::-1], closed)[1].any() == (not closed)
