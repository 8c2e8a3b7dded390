"""Geometry and context of an image."""

from __future__ import annotations

import numpy as np
import pytest

from tacos_framework.formation.views import light_context
from tacos_framework.testing.samples import sample_capture, sample_exposure
from tacos_framework.values import Camera, ContextMissing, ImageContext, ImageGeometry


def test_a_camera_is_its_whole_sensor_in_simulated_pixels():
    camera = Camera(
        "c", 40, 30, pixel_um=1.5, focal_length_mm=2.0, binning=2, principal_point_px=(18.0, 16.0)
    )
    geometry = ImageGeometry.of_camera(camera)
    assert geometry.pixel_um == 3.0
    assert geometry.focal_length_px == camera.focal_length_px
    assert geometry.half_diagonal_px == 25.0
    assert geometry.radius[16, 18] == 0.0
    assert geometry.radius[16 + 12, 18 - 16] == pytest.approx(20 / 25)


def test_a_crop_of_a_crop_lies_where_it_does_on_the_sensor():
    full = ImageGeometry(64, 48, focal_length_px=50, centre_px=(30.0, 25.0), pixel_um=3)
    twice = full.crop(x=10, y=4, width_px=40, height_px=40).crop(x=5, y=6, width_px=20, height_px=10)
    assert twice == full.crop(x=15, y=10, width_px=20, height_px=10)
    np.testing.assert_allclose(twice.radius, full.radius[10:20, 15:35])
    np.testing.assert_array_equal(twice.sensor_row.ravel(), np.arange(10, 20))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"width_px": 0}, "0 x 48 has no pixels"),
        ({"pixel_um": 0.0}, "pixel_um must be above 0"),
        ({"offset_px": (1, 0)}, "columns 1 .. 65 are not on a sensor of 64 columns"),
        ({"offset_px": (0, 9), "full_height_px": 50}, "rows 9 .. 57 are not on a sensor of 50 rows"),
    ],
)
def test_what_cannot_be_is_refused(changes, message):
    right = {"width_px": 64, "height_px": 48, "focal_length_px": 50.0, "centre_px": (3, 3), "pixel_um": 3.0}
    with pytest.raises(ValueError, match=message):
        ImageGeometry(**{**right, **changes})


def test_a_context_says_what_it_lacks():
    for ask in ("known_f_number", "known_depth_m", "known_velocity_px_s"):
        with pytest.raises(ContextMissing, match=r"effect\.x needs the"):
            getattr(ImageContext(), ask)("effect.x")


def test_a_rendered_view_knows_its_exposure_and_depth():
    capture = sample_capture()
    view = capture.views[0]
    context = light_context(view, capture.episode, sample_exposure(f_number=4.0))
    assert context.known_f_number("x") == 4.0
    assert context.known_depth_m("x") is view.depth_m
    assert context.reference_row == 23.5
    assert context.known_velocity_px_s("x").shape == (*view.depth_m.shape, 2)  # worked out when asked for
