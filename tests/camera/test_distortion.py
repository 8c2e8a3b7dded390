"""Lens distortion against OpenCV."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from opencv_undistortion import undistorted

from tacos_framework.values import BrownConrady, Lens
from tacos_plugins.effects.powers_of_angle import radius_without

PINHOLE = np.eye(3)
STILL = np.zeros(3)


def grid(reach):
    x, y = np.meshgrid(np.linspace(-reach, reach, 15), np.linspace(-0.7 * reach, 0.7 * reach, 11))
    return x.ravel(), y.ravel()


@pytest.mark.parametrize(
    "lens",
    [
        BrownConrady(k1=-0.3, k2=0.1, k3=-0.01, p1=0.002, p2=-0.003),
        BrownConrady(k1=0.2),
        BrownConrady(p1=0.01),
    ],
)
def test_brown_and_conrady_is_opencvs(lens):
    x, y = grid(0.8)
    points = np.stack([x, y, np.ones_like(x)], axis=1)
    expected, _ = cv2.projectPoints(points, STILL, STILL, PINHOLE, np.array([*lens[:2], *lens[3:], lens.k3]))
    np.testing.assert_allclose(np.stack(lens.distorted(x, y), axis=1), expected[:, 0], atol=1e-12)


def test_its_inverse_is_opencvs():
    lens = BrownConrady(k1=-0.25, k2=0.08, p1=0.002, p2=-0.001)
    x, y = grid(0.5)
    coefficients = np.array([lens.k1, lens.k2, lens.p1, lens.p2, lens.k3])
    points = np.stack([x, y], axis=1)[:, None]
    expected = undistorted(points, PINHOLE, coefficients)
    np.testing.assert_allclose(np.stack(lens.undistorted(x, y), axis=1), expected, atol=1e-6)


@given(
    k1=st.floats(-0.3, 0.5),
    k2=st.floats(-0.05, 0.2),
    k3=st.floats(0.0, 0.05),
    p1=st.floats(-0.01, 0.01),
    p2=st.floats(-0.01, 0.01),
)
@settings(max_examples=40, deadline=None)
def test_the_inverse_undoes_the_lens(k1, k2, k3, p1, p2):
    lens = BrownConrady(k1=k1, k2=k2, k3=k3, p1=p1, p2=p2)
    x, y = grid(0.6)
    back = lens.undistorted(*lens.distorted(x, y))
    np.testing.assert_allclose(np.stack(back), np.stack([x, y]), atol=1e-7)  # near a fold, else closer


@pytest.mark.parametrize("p1", [-0.01, 0.01])
@pytest.mark.parametrize("p2", [-0.01, 0.01])
@pytest.mark.parametrize(("k1", "k2", "k3"), [(-0.15, 0.08, -0.03), (0.1, -0.05, 0.05), (0.5, 0.2, 0.05)])
def test_away_from_a_fold_the_inverse_is_exact(k1, k2, k3, p1, p2):
    lens = BrownConrady(k1, k2, k3, p1, p2)
    x, y = grid(0.6)
    back = lens.undistorted(*lens.distorted(x, y))
    np.testing.assert_allclose(np.stack(back), np.stack([x, y]), atol=1e-11)


def test_the_inverse_undoes_a_lens_that_draws_a_wide_image_in():
    x, y = grid(2.0)
    back = BrownConrady(k1=-0.02).undistorted(*BrownConrady(k1=-0.02).distorted(x, y))
    np.testing.assert_allclose(np.stack(back), np.stack([x, y]), atol=1e-12)


def test_beyond_the_fold_of_a_strong_barrel_the_last_circle_stands_in():
    lens = BrownConrady(k1=-0.5)
    fold = np.sqrt(1 / 1.5)  # where d/dr (r - 0.5 r^3) = 0
    x, y = lens.undistorted(np.array([2.0, 0.0]), np.array([0.0, -5.0]))
    assert np.hypot(x, y) == pytest.approx(fold, rel=5e-3)
    assert x[0] > 0
    assert y[1] < 0


@pytest.mark.parametrize("lens", [BrownConrady(k1=-0.3), BrownConrady(k1=0.1, k2=-0.05)])
def test_it_turns_back_at_its_fold(lens):
    before, fold, after = lens.radial(lens.fold * np.array([0.999, 1.0, 1.001]))
    assert fold > max(before, after)


@pytest.mark.parametrize("coefficients", [(0.05, -0.02, 0.003), (0.2, 0.05, 0.02)])
def test_the_effects_fisheye_is_opencvs(coefficients):
    x, y = grid(2.0)
    points = np.stack([x, y, np.ones_like(x)], axis=1)[:, None]
    there, _ = cv2.fisheye.projectPoints(points, STILL, STILL, PINHOLE, np.array([*coefficients, 0.0]))
    back = radius_without(np.hypot(*there[:, 0].T), (*coefficients, 0.0), Lens())
    np.testing.assert_allclose(back, np.hypot(x, y), atol=1e-12)


def test_a_flat_image_ends_before_the_fisheyes_horizon():
    edge = radius_without(np.array([1.8]), (0.0, 0.0, 0.0, 0.0), Lens())
    assert edge == pytest.approx(np.tan(np.radians(89)))
