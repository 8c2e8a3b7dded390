"""Clip space: what the projection matrix keeps, and the planes that bound it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tacos_framework.values import Camera
from tacos_plugins.renderers.moderngl.culling import frustum_planes
from tacos_plugins.renderers.moderngl.projection import projection_matrix


def a_camera(**more):
    return Camera("c", 640, 480, pixel_um=3.0, focal_length_mm=2.0, **more)


def test_matrix_maps_pixel_edges_and_depths_to_the_edges_of_clip_space():
    camera = a_camera(principal_point_px=(100.0, 400.0))
    matrix = projection_matrix(camera, 0.5, 20.0)
    rays = np.linalg.inv(camera.intrinsics) @ np.array([[-0.5, 639.5], [-0.5, 479.5], [1.0, 1.0]])
    for depth, z in ((0.5, -1.0), (20.0, 1.0)):
        points = np.vstack([rays * depth, np.ones((1, 2))])
        clip = matrix @ points
        ndc = clip[:3] / clip[3]
        np.testing.assert_allclose(ndc, [[-1, 1], [-1, 1], [z, z]], atol=1e-9)
        np.testing.assert_allclose(clip[3], depth)


@pytest.mark.parametrize(("near_m", "far_m"), [(2, 1), (2, 2), (0, 1)])
def test_matrix_refuses_a_depth_range_that_does_not_rise(near_m, far_m):
    with pytest.raises(ValueError, match=rf"rise from above 0, not {near_m} \.\. {far_m} m"):
        projection_matrix(a_camera(), near_m, far_m)


@given(st.tuples(st.floats(-30, 30), st.floats(-30, 30), st.floats(-30, 30)))
def test_frustum_planes_keep_what_the_matrix_keeps(point):
    matrix = projection_matrix(a_camera(), 0.5, 20.0)
    x, y, z, w = matrix @ [*point, 1.0]
    planes = frustum_planes(matrix)
    inside = (planes[:, :3] @ point + planes[:, 3] >= 0).all()
    margin = min(w - abs(x), w - abs(y), w - abs(z))
    if abs(margin) > 1e-6:
        assert inside == (margin > 0)


def test_frustum_planes_tell_how_far_the_edges_of_the_image_and_the_depth_range_are():
    camera = a_camera(principal_point_px=(100.0, 400.0))
    planes = frustum_planes(projection_matrix(camera, 0.5, 20.0))
    np.testing.assert_allclose(np.linalg.norm(planes[:, :3], axis=1), 1.0)
    corners_px = np.array([[-0.5, -0.5], [639.5, -0.5], [639.5, 479.5], [-0.5, 479.5]])
    rays = np.column_stack([(corners_px - camera.centre_px) / camera.focal_length_px, np.ones(4)])
    distance = 3.0 * rays @ planes[:, :3].T + planes[:, 3]
    on_edge = [[0, 2], [1, 2], [1, 3], [0, 3]]  # left, right, first row, last row
    for corner, edges in enumerate(on_edge):
        np.testing.assert_allclose(distance[corner, edges], 0.0, atol=1e-9)
        np.testing.assert_array_less(0.1, np.delete(distance[corner], edges))
    np.testing.assert_allclose(distance[:, 4:], np.tile([3.0 - 0.5, 20.0 - 3.0], (4, 1)))
