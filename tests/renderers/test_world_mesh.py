"""Flattening a world: charts of the light map, chunks, closed parts, smooth surfaces."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from small_worlds import box, matte, pose, quad, room, world

from tacos_framework.camera.geometry import invert_pose, project
from tacos_framework.values import Camera, MeshPart
from tacos_plugins.renderers.light.charts import MOST_TEXELS, find_charts, pack_shelves
from tacos_plugins.renderers.light.flatten import cut_into_chunks, flatten
from tacos_plugins.renderers.light.prefilter import ggx_lobe, octahedral_directions
from tacos_plugins.renderers.light.surfaces import closed_parts, smooth_surfaces
from tacos_plugins.renderers.light.tangents import tangent_frames
from tacos_plugins.renderers.moderngl.culling import Culling
from tacos_plugins.renderers.moderngl.projection import projection_matrix


def mesh_of(parts):
    place = world(parts, [matte()])
    return flatten(place, place.indirect_lux)


def merged(parts):
    """One part of many."""
    firsts = np.cumsum([0] + [len(p.vertices_m) for p in parts])
    return MeshPart(
        np.concatenate([p.vertices_m for p in parts]),
        np.concatenate([p.normals for p in parts]),
        np.concatenate([p.uv_m for p in parts]),
        np.concatenate([p.triangles + f for p, f in zip(parts, firsts, strict=False)]),
        0,
        0,
    )


@given(st.lists(st.tuples(st.integers(1, 40), st.integers(1, 40)), min_size=1, max_size=40))
def test_rectangles_of_the_light_map_do_not_overlap(sizes):
    size = np.array(sizes, np.int32)
    place, (columns, rows) = pack_shelves(size)
    used = np.zeros((rows, columns), int)
    for (x, y), (w, h) in zip(place, size, strict=True):
        used[y : y + h, x : x + w] += 1
    assert used.max() == 1
    assert used.sum() == size.prod(axis=1).sum()


def test_texels_of_a_chart_lie_where_their_coordinates_point():
    mesh = mesh_of([quad((1.0, 2.0, 0.5), (0.6, 0.8, 0.0), (0.0, 0.0, 0.45))])
    charts = find_charts(mesh, 0.1)
    assert len(charts) == 1
    chart, column, row = charts.texels()
    points = charts.points(chart, column, row)
    texel = charts.coordinates(chart, points) * charts.map_size - 0.5
    expected = charts.place[chart] + np.column_stack([column, row])
    np.testing.assert_allclose(texel, expected, atol=0.11)  # those at the rim are drawn in a little
    spans = np.ptp(points, axis=0)
    np.testing.assert_allclose(spans, [1.2, 1.6, 0.9], atol=0.03)


def test_a_huge_floor_gets_a_coarser_map_instead_of_a_larger_one():
    charts = find_charts(mesh_of([quad((0, 0, 0), (200, 0, 0), (0, 200, 0))]), 0.05)
    assert np.prod(charts.map_size) < 1.1 * MOST_TEXELS


def test_only_bodies_that_face_outwards_are_closed():
    body = merged(box((0, 0, 0), (1, 2, 3)))
    shell = merged(room((0, 0, 0), (1, 2, 3)))
    sheet = quad((0, 0, 0), (1, 0, 0), (0, 1, 0))
    open_box = merged(box((0, 0, 0), (1, 2, 3))[:-1])
    closed = closed_parts(mesh_of([body, shell, sheet, open_box]))
    assert closed.tolist() == [True, False, False, False]


def test_each_side_of_a_box_is_a_surface_and_a_sheet_of_triangles_is_one():
    mesh = mesh_of([merged(box((0, 0, 0), (1, 1, 1)))])
    assert len(np.unique(smooth_surfaces(mesh))) == 6
    row = [quad((2 * i, 0, 0), (1, 0, 0), (0, 1, 0)) for i in range(5)]
    assert len(np.unique(smooth_surfaces(mesh_of([merged(row)])))) == 1
    assert len(np.unique(smooth_surfaces(mesh_of(row)))) == 5  # parts do not mix


def test_chunks_hold_every_triangle_once_within_their_bounds():
    rng = np.random.default_rng(0)
    parts = [quad(c, (0.1, 0, 0), (0, 0.1, 0)) for c in rng.uniform(0, 9, (400, 3))]
    mesh = mesh_of(parts)
    kind = (np.arange(len(mesh.triangles)) % 3 == 0).astype(np.int32)
    order, chunks = cut_into_chunks(mesh, kind, np.zeros(len(kind), np.int32))
    assert sorted(order) == list(range(len(mesh.triangles)))
    assert chunks.count.sum() == len(order)
    for first, count, lower, upper, of_kind in zip(
        chunks.first, chunks.count, chunks.lower_m, chunks.upper_m, chunks.kind, strict=True
    ):
        run = order[first : first + count]
        assert (kind[run] == of_kind).all()
        assert (mesh.corners_m[run] >= lower - 1e-6).all()
        assert (mesh.corners_m[run] <= upper + 1e-6).all()


def test_culling_keeps_every_triangle_with_a_corner_in_view():
    rng = np.random.default_rng(0)
    mesh = mesh_of([quad(c, (0.1, 0, 0), (0, 0.1, 0)) for c in rng.uniform(-9, 9, (500, 3))])
    order, chunks = cut_into_chunks(mesh, *np.zeros((2, len(mesh.triangles)), np.int32))
    triangles = mesh.triangles[order]
    culling = Culling(chunks, triangles, np.ones(len(mesh.position_m), np.int32))
    camera = Camera("c", 64, 48, pixel_um=2.0, focal_length_mm=0.1)
    from_camera = pose((0, 0, 0)) @ np.eye(4)[[2, 0, 1, 3]]
    clip = projection_matrix(camera, 0.05, 30.0) @ invert_pose(from_camera)
    kept = culling.in_frustum(clip)
    assert 0 < len(kept) < len(chunks.first)
    pixels, depth = project(mesh.position_m, camera, from_camera)
    seen = (depth > 0.05) & ((pixels > 0) & (pixels < [63, 47])).all(axis=1)
    chunk = np.repeat(np.arange(len(chunks.first)), chunks.count)
    assert set(chunk[seen[triangles].any(axis=1)]) <= set(kept)


@pytest.mark.parametrize("mirrored", [False, True])
def test_tangents_follow_the_texture(mirrored):
    sheet = quad((0, 0, 0), (1, 0, 0), (0, 1, 0))
    uv = sheet.uv_m * [-1, 1] if mirrored else sheet.uv_m
    part = MeshPart(sheet.vertices_m, sheet.normals, uv, sheet.triangles, 0, 0)
    frames = tangent_frames(mesh_of([part]))
    np.testing.assert_allclose(frames[:, 0], [[-1.0 if mirrored else 1.0, 0, 0]] * 4, atol=1e-6)
    np.testing.assert_allclose(frames[:, 1], [[0, 1, 0]] * 4, atol=1e-6)


def test_octahedral_layer_covers_the_sphere_evenly():
    directions = octahedral_directions()
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1.0, rtol=1e-5)
    assert np.abs(directions.mean(axis=0)).max() < 0.03  # the border repeats one pole
    assert np.abs(directions.T @ directions / len(directions) - np.eye(3) / 3).max() < 0.05


@pytest.mark.parametrize(("roughness", "least_mean_cosine"), [(0.1, 0.99), (0.5, 0.8)])
def test_rough_lobes_are_wider(roughness, least_mean_cosine):
    direction, weight = ggx_lobe(roughness, 64)
    assert weight.sum() == pytest.approx(1.0)
    mean_cosine = float(direction[:, 2] @ weight)
    assert least_mean_cosine < mean_cosine < (1.0 if roughness < 0.2 else 0.97)
