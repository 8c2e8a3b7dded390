"""Pixels to directions and back through every lens, against OpenCV and closed forms."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tacos_framework.camera import (
    along_axis_m,
    distance_m,
    pixel_rays,
    pixels_of_rays,
    project,
    rays_of_pixels,
)
from tacos_framework.camera.motion import reprojected
from tacos_framework.values import Camera, ImageGeometry, Lens

T265 = Lens("kannala-brandt", (-0.003, 0.054, -0.052, 0.011), half_field_deg=81.5)
LENSES = {
    "pinhole": Lens(),
    "circle": Lens("rectilinear", half_field_deg=40),
    "distorted": Lens("rectilinear", (-0.25, 0.08, 0.002, -0.001, -0.01)),
    "equidistant": Lens("equidistant", half_field_deg=95),
    "equisolid": Lens("equisolid", half_field_deg=100),
    "stereographic": Lens("stereographic", half_field_deg=100),
    "kannala-brandt": T265,
}


def a_camera(lens, width_px=848, height_px=800, focal_px=282.0):
    return Camera(
        "c", width_px, height_px, 3.0, focal_px * 3e-3, principal_point_px=(420.3, 404.1), lens=lens
    )


@pytest.mark.parametrize("name", LENSES)
def test_a_pixel_looks_where_it_is_seen_from(name):
    camera = a_camera(LENSES[name])
    pixels = np.random.default_rng(1).uniform((0, 0), (847, 799), (4000, 2))
    rays = rays_of_pixels(pixels, camera)
    imaged = np.isfinite(rays[:, 0])
    assert imaged.mean() > 0.25
    np.testing.assert_allclose(np.linalg.norm(rays[imaged], axis=1), 1.0, atol=1e-12)
    away = imaged & (np.arccos(rays[:, 2]) < 0.95 * camera.lens.reach_rad)  # at a fold places run together
    np.testing.assert_allclose(pixels_of_rays(rays[away] * 7.0, camera), pixels[away], atol=1e-7)


@given(st.sampled_from(sorted(LENSES)), st.floats(0, np.pi), st.floats(-np.pi, np.pi), st.floats(100, 1000))
def test_a_direction_is_imaged_where_it_is_looked_at(name, angle, azimuth, focal_px):
    camera = a_camera(LENSES[name], focal_px=focal_px)
    across = np.sin(angle)
    ray = np.array([across * np.cos(azimuth), across * np.sin(azimuth), np.cos(angle)])
    pixel = pixels_of_rays(ray, camera)
    if angle > camera.lens.widest_rad * (1 + 1e-6):
        assert np.isnan(pixel).all()
    elif angle < 0.98 * camera.lens.widest_rad:
        np.testing.assert_allclose(rays_of_pixels(pixel, camera), ray, atol=1e-6)


@pytest.mark.parametrize("coefficients", [T265.coefficients, (0.1, -0.02), ()])
def test_kannala_and_brandt_is_opencvs_fisheye(coefficients):
    camera = a_camera(Lens("kannala-brandt", coefficients))
    rng = np.random.default_rng(2)
    points = rng.uniform((-1, -1, 0.2), (1, 1, 2.2), (500, 1, 3))
    four = np.zeros(4)
    four[: len(coefficients)] = coefficients
    expected, _ = cv2.fisheye.projectPoints(points, np.zeros(3), np.zeros(3), camera.intrinsics, four)
    np.testing.assert_allclose(pixels_of_rays(points[:, 0], camera), expected[:, 0], atol=1e-9)


def test_a_distorted_rectilinear_lens_is_opencvs():
    camera = a_camera(LENSES["distorted"])
    points = np.random.default_rng(3).uniform((-0.4, -0.4, 0.6), (0.4, 0.4, 1.4), (500, 3))
    expected, _ = cv2.projectPoints(
        points, np.zeros(3), np.zeros(3), camera.intrinsics, np.array(camera.lens.coefficients)
    )
    np.testing.assert_allclose(pixels_of_rays(points, camera), expected[:, 0], atol=1e-9)


def test_a_circle_on_the_sphere_is_a_circle_of_the_stereographic_image():
    camera = a_camera(Lens("stereographic"))
    around = np.linspace(0, 2 * np.pi, 50)
    centre, one, other = np.linalg.qr(np.array([[0.7, 0.1, 1], [0, 1, 0], [0.3, 0.2, 0.1]]))[0]
    rays = centre + 0.4 * (np.cos(around)[:, None] * one + np.sin(around)[:, None] * other)
    x, y = pixels_of_rays(rays, camera).T
    terms = np.column_stack([x, y, np.ones_like(x)])
    left = terms @ np.linalg.lstsq(terms, x**2 + y**2, rcond=None)[0] - (x**2 + y**2)
    assert np.abs(left).max() < 1e-5


def test_equal_solid_angles_have_equal_areas():
    camera = a_camera(Lens("equisolid"))
    caps = np.array([0.3, 1.0, 2.0, 3.0])
    radius = pixels_of_rays(np.column_stack([np.sin(caps), 0 * caps, np.cos(caps)]), camera)[:, 0] - 420.3
    np.testing.assert_allclose(np.pi * radius**2 / (2 * np.pi * (1 - np.cos(caps))), 282.0**2, rtol=1e-9)


@pytest.mark.parametrize(
    ("lens", "field_deg"),
    [
        (Lens("equidistant"), np.degrees(848 / 282)),
        (Lens("equidistant", half_field_deg=80), 160.0),
        (Lens("equisolid"), np.degrees(4 * np.arcsin(848 / 282 / 4))),
        (Lens("stereographic"), np.degrees(4 * np.arctan(848 / 282 / 4))),
        (Lens(), np.degrees(2 * np.arctan(848 / 282 / 2))),
    ],
)
def test_the_field_of_view_is_that_of_the_projection(lens, field_deg):
    camera = a_camera(lens)
    assert camera.hfov_deg == pytest.approx(field_deg, rel=1e-12)
    if lens.half_field_deg is None:
        assert lens.size_of_field(field_deg) == pytest.approx(848 / 282, rel=1e-12)


def test_the_t265_reaches_183_degrees_at_the_edges_of_its_image():
    assert a_camera(Lens("kannala-brandt", T265.coefficients)).hfov_deg == pytest.approx(
        183, abs=1.5
    )  # published to three digits
    assert a_camera(T265).hfov_deg == pytest.approx(163)


@pytest.mark.parametrize(
    ("lens", "message"),
    [
        (lambda: Lens("rectilinear", half_field_deg=95), "ends below 180 deg"),
        (lambda: Lens("kannala-brandt", (-0.2,), half_field_deg=95), "images up to 73.97 deg off its axis"),
        (lambda: Lens("equidistant", (0.1,)), "projection equidistant has 0 coefficients, not 1"),
        (lambda: Lens("fisheye"), "no projection 'fisheye': expected rectilinear, equidistant"),
        (lambda: Lens().size_of_field(180), "a field of view of 180 deg, where a rectilinear lens"),
        (lambda: Lens("kannala-brandt", (float("nan"),)), "must be finite"),
    ],
)
def test_lenses_that_cannot_be_are_refused(lens, message):
    with pytest.raises(ValueError, match=message):
        lens()


def test_depth_of_a_fisheye_is_distance_and_has_an_axis_all_the_same():
    camera = a_camera(LENSES["equidistant"])
    point = np.array([[1.0, -1.0, -0.05]])  # beside the camera, and a little behind
    pixel, depth = project(point, camera, np.eye(4))
    assert depth == pytest.approx(np.linalg.norm(point))
    row, column = round(pixel[0, 1]), round(pixel[0, 0])
    image = np.full((800, 848), np.inf)
    image[row, column] = depth[0]
    np.testing.assert_allclose(image[row, column] * pixel_rays(camera)[row, column], point[0], atol=5e-3)
    assert along_axis_m(image, camera)[row, column] == pytest.approx(-0.05, abs=5e-3)
    assert distance_m(image, camera)[row, column] == pytest.approx(depth[0])
    assert np.isinf(along_axis_m(image, camera)[0, 0])


@pytest.mark.parametrize("name", ["equidistant", "kannala-brandt", "distorted", "circle"])
def test_what_moves_is_reprojected_through_the_lens(name):
    camera = a_camera(LENSES[name])
    rng = np.random.default_rng(4)
    points = rng.uniform(-1, 1, (200, 3)) * [1, 1, 0.3] + [0, 0, 1.5]
    pixels, depth = project(points, camera, np.eye(4))
    seen = np.isfinite(pixels[:, 0])
    other = np.eye(4)
    other[:3, :3], other[:3, 3] = cv2.Rodrigues(np.array([0.02, -0.03, 0.01]))[0], (0.01, -0.02, 0.03)
    x, y, scale = reprojected(*pixels[seen].T, 1 / depth[seen], ImageGeometry.of_camera(camera), other)
    expected, far = project(points[seen], camera, np.linalg.inv(other))
    still = np.isfinite(expected[:, 0])
    np.testing.assert_allclose(np.column_stack([x, y])[still], expected[still], atol=1e-5)
    np.testing.assert_allclose(scale, far / depth[seen], rtol=1e-6)
