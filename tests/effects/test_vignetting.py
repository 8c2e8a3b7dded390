"""The vignetting effect."""

from __future__ import annotations

import numpy as np
import pytest

from tacos_framework.testing.forming import placed, with_effect
from tacos_framework.testing.samples import sample_capture, sample_rig
from tacos_framework.values import ImageGeometry
from tacos_plugins.effects.radial import even_polynomial
from tacos_plugins.effects.vignetting import Vignetting


def apply(capture, **coefficients):
    return with_effect(capture, placed(Vignetting, **coefficients))


def test_light_falls_with_the_polynomial_of_the_radius():
    geometry = ImageGeometry(401, 301, focal_length_px=500, centre_px=(200, 150), pixel_um=3)
    field = even_polynomial(geometry.radius, -0.4, -0.1, 0.05)
    half_diagonal = np.hypot(401, 301) / 2
    assert field[150, 200] == 1.0
    for row, column in [(0, 0), (300, 400), (150, 0), (20, 333)]:
        r = np.hypot(column - 200, row - 150) / half_diagonal
        assert field[row, column] == pytest.approx(1 - 0.4 * r**2 - 0.1 * r**4 + 0.05 * r**6)


def test_it_is_centred_on_the_principal_point():
    geometry = ImageGeometry(40, 30, focal_length_px=50, centre_px=(10.0, 20.0), pixel_um=3)
    field = even_polynomial(geometry.radius, -0.4, 0, 0)
    assert np.unravel_index(field.argmax(), field.shape) == (20, 10)


def test_light_never_turns_negative():
    geometry = ImageGeometry(40, 30, focal_length_px=50, centre_px=(19.5, 14.5), pixel_um=3)
    assert even_polynomial(geometry.radius, -3, 0, 0).min() == 0.0


def test_in_a_crop_the_radius_still_runs_over_the_whole_sensor():
    full = ImageGeometry(64, 48, focal_length_px=50, centre_px=(30.0, 25.0), pixel_um=3)
    crop = full.crop(x=40, y=10, width_px=20, height_px=30)
    whole = even_polynomial(full.radius, -0.4, 0.1, 0)
    np.testing.assert_array_equal(even_polynomial(crop.radius, -0.4, 0.1, 0), whole[10:40, 40:60])


def test_every_channel_frame_and_camera_is_dimmed_alike_and_nothing_else_changes():
    capture = sample_capture(sample_rig("left", "right"), frames=2)
    dimmed = apply(capture, k1=-0.5)
    for before, after in zip(capture.views, dimmed.views, strict=True):
        expected = even_polynomial(ImageGeometry.of_camera(before.camera).radius, -0.5)[..., None]
        np.testing.assert_allclose(after.luminance_cd_m2, before.luminance_cd_m2 * expected, rtol=1e-6)
        np.testing.assert_array_equal(after.depth_m, before.depth_m)
        np.testing.assert_array_equal(after.object_id, before.object_id)
    assert dimmed.episode is capture.episode
