"""Light, depth and labels at new places."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import shift

from tacos_framework.camera import resampling
from tacos_framework.camera.resampling import nearest, resample, resample_inverse_depth

Y, X = np.mgrid[:40, :50].astype(np.float64)


def test_a_wave_is_read_between_pixels():
    wave = 2 + np.cos(2 * np.pi * (0.1 * X + 0.05 * Y))
    x, y = X[10:30, 10:40] + 0.37, Y[10:30, 10:40] - 0.21
    found = resample(wave[None, :, :, None], x, y)[0, :, :, 0]
    np.testing.assert_allclose(found, 2 + np.cos(2 * np.pi * (0.1 * x + 0.05 * y)), atol=2e-3)


def test_light_is_where_scipy_shifts_it():
    image = np.random.default_rng(0).random((40, 50))
    found = resample(image[None, :, :, None], X - 1.3, Y + 0.4)[0, :, :, 0]
    expected = np.clip(shift(image, (-0.4, 1.3), order=5, mode="nearest"), image.min(), image.max())
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_a_move_of_a_thousandth_of_a_pixel_counts():
    ramp = np.tile(X, (1, 1, 1))[..., None]
    moved = resample(ramp, X[:, 10:40] + 1e-3, Y[:, 10:40])[0, :, :, 0]
    np.testing.assert_allclose(moved - X[:, 10:40], 1e-3, atol=1e-6)


def test_outside_the_image_its_edge_goes_on_and_no_light_is_made():
    frames = np.zeros((2, 40, 50, 3), np.float32)
    frames[:, :, 25:] = 7
    found = resample(frames, X + 30, Y)
    assert found.dtype == np.float32
    np.testing.assert_allclose(found[:, :, 25:], 7)
    edge = resample(frames, X + 0.5, Y)
    assert edge.min() >= 0
    assert edge.max() <= 7


def test_each_frame_may_look_elsewhere():
    frames = np.stack([X, X])[..., None]
    found = resample(frames, np.stack([X, X + 2]), np.stack([Y, Y]))[..., 0]
    np.testing.assert_allclose(found[1, :, 10:40] - found[0, :, 10:40], 2, atol=1e-6)


def test_labels_stay_whole():
    labels = (X > 20).astype(np.int32)[None] * 7
    found = nearest(labels, X + 0.4, Y)
    assert found.dtype == np.int32
    np.testing.assert_array_equal(found[0], labels[0])
    np.testing.assert_array_equal(nearest(labels, X + 0.6, Y)[0, :, :-1], labels[0, :, 1:])


def test_depth_is_exact_on_a_plane_and_never_between_two_surfaces():
    plane = 0.2 + 0.004 * X + 0.002 * Y
    found = resample_inverse_depth(plane[None], X[:, 5:40] + 0.25, Y[:, 5:40] + 0.0)
    np.testing.assert_allclose(found[0], 0.2 + 0.004 * (X[:, 5:40] + 0.25) + 0.002 * Y[:, 5:40])
    step = np.where(X > 25, 1.0, 0.0)  # one metre away, before nothing
    assert set(np.unique(resample_inverse_depth(step[None], X + 0.3, Y))) == {0.0, 1.0}


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_types_stay(dtype):
    assert resample_inverse_depth(np.ones((1, 40, 50), dtype), X, Y).dtype == dtype


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_an_even_picture_looks_the_same_from_everywhere_without_a_spline(dtype, monkeypatch):
    rows, columns = np.mgrid[-30:70:2.5, -40:90:3.25]
    even = np.full((2, 40, 50, 3), [0.1, 7.3, 211.7], dtype)
    by_spline = resample(even + np.linspace(0, 1e-3, 50, dtype=dtype)[:, None], columns, rows)
    monkeypatch.setattr(resampling, "spline_filter", lambda *args, **kwargs: pytest.fail("filtered"))
    seen = resample(even, columns, rows)
    np.testing.assert_array_equal(seen, np.broadcast_to(even[:, :1, :1], seen.shape))
    np.testing.assert_allclose(seen, by_spline, atol=2e-3)
