"""Blur by depth."""

from __future__ import annotations

import numpy as np
import pytest

from tacos_framework.values import ImageGeometry
from tacos_plugins.effects.blur import blur
from tacos_plugins.effects.depth_of_field import blur_by_depth, signed_radius
from tacos_plugins.effects.disc import disc_kernel


def test_at_twice_the_focus_distance_the_circle_is_that_of_the_thin_lens():
    geometry = ImageGeometry(8, 8, focal_length_px=4 / 3e-3, centre_px=(3.5, 3.5), pixel_um=3)
    f, n, s, z = 4e-3, 2.0, 0.5, 1.0
    image_of_focus, image_of_point = s * f / (s - f), z * f / (z - f)
    diameter = f / n * abs(image_of_point - image_of_focus) / image_of_point
    radius = signed_radius(np.array([z]), geometry, f_number=n, focus_m=s)
    assert radius * 3e-6 == pytest.approx(diameter / 2, rel=1e-9)


def test_of_one_depth_it_is_the_plain_disc():
    light = np.random.default_rng(1).uniform(0, 10, (1, 40, 50, 3))
    radius = 1.25
    found = blur_by_depth(light, np.full((1, 40, 50), radius))
    expected = blur(light, disc_kernel(radius))
    # Two neighbouring radii of the same variance stand in for it.
    assert np.abs(found - expected).mean() < 0.03 * light.std()


def test_in_focus_nothing_changes():
    light = np.random.default_rng(1).uniform(0, 10, (1, 20, 30, 1))
    np.testing.assert_allclose(blur_by_depth(light, np.zeros((1, 20, 30))), light)


def test_what_is_behind_does_not_bleed_into_a_sharp_thing_before_it():
    light, radius = np.full((1, 60, 60, 1), 100.0), np.full((1, 60, 60), 8.0)
    light[:, :, :30], radius[:, :, :30] = 1.0, 0.0  # a dark thing in focus, before a bright far wall
    blurred = blur_by_depth(light, radius)
    np.testing.assert_allclose(blurred[0, :, :29, 0], 1.0, rtol=0.05)


def test_a_near_thing_out_of_focus_overlaps_what_is_behind():
    light, radius = np.full((1, 60, 60, 1), 100.0), np.zeros((1, 60, 60))
    light[:, :, :30], radius[:, :, :30] = 0.0, -8.0
    row = blur_by_depth(light, radius)[0, 30, :, 0]
    kernel = disc_kernel(8.0)
    cover = blur((radius < 0).astype(np.float64)[..., None], kernel)[0, 30, :, 0]
    np.testing.assert_allclose(row[30:], 100 * (1 - cover[30:]), atol=4)  # the wall shows through


def test_light_is_neither_made_nor_lost_where_depth_changes_smoothly():
    light = np.random.default_rng(4).uniform(0, 10, (1, 80, 80, 1))
    radius = np.broadcast_to(np.linspace(-3, 5, 80), (1, 80, 80))
    assert blur_by_depth(light, radius).mean() == pytest.approx(light.mean(), rel=0.01)


@pytest.mark.parametrize("radius", [0.3, 1.0, 2.5, 7.0])
def test_a_lamp_out_of_focus_has_no_dark_ring(radius):
    """Streets by night: a lamp a thousand times as bright as what is around it."""
    light = np.full((1, 41, 41, 3), 0.01)
    light[:, 20, 20] = 10.0
    for sign in (-1, 1):
        blurred = blur_by_depth(light, np.full((1, 41, 41), sign * radius))
        assert blurred.min() >= 0.01 * (1 - 1e-9)
        assert blurred.sum() == pytest.approx(light.sum(), rel=1e-6)
