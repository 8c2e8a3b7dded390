"""Blur from transfer functions."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import gaussian_filter

from tacos_plugins.effects.blur import (
    airy_transfer,
    blur,
    gaussian_transfer,
    kernel_of,
    line_transfer,
)


def contrast_left(kernel, frequency, angle_deg=0.0):
    """Amplitude of a wave after the blur, by running a real wave through it."""
    y, x = np.mgrid[:160, :160].astype(np.float64)
    direction = np.radians(angle_deg)
    phase = 2 * np.pi * frequency * (x * np.cos(direction) + y * np.sin(direction))
    wave = 2 + np.cos(phase)
    blurred = blur(wave[None, :, :, None], kernel)[0, 40:120, 40:120, 0] - 2
    reference = np.cos(phase)[40:120, 40:120]
    return float((blurred * reference).sum() / (reference**2).sum())


@pytest.mark.parametrize("sigma_px", [0.2, 0.5, 1.3])
@pytest.mark.parametrize("frequency", [0.05, 0.15, 0.3])
def test_a_gaussian_leaves_its_textbook_contrast_however_narrow(sigma_px, frequency):
    kernel = kernel_of(gaussian_transfer(sigma_px), reach_px=4 * sigma_px)
    expected = np.exp(-2 * (np.pi * sigma_px * frequency) ** 2)
    assert contrast_left(kernel, frequency, angle_deg=20) == pytest.approx(expected, abs=0.01)


def test_a_wide_gaussian_is_scipys():
    image = np.random.default_rng(0).uniform(0, 100, (60, 70))
    kernel = kernel_of(gaussian_transfer(2.0), reach_px=8)
    expected = gaussian_filter(image, 2.0, mode="nearest", truncate=6)
    found = blur(image[None, :, :, None], kernel)[0, :, :, 0]
    np.testing.assert_allclose(found, expected, atol=0.02)


@pytest.mark.parametrize("angle_deg", [0.0, 30.0, 90.0])
def test_a_line_leaves_a_sinc_along_it_and_all_across(angle_deg):
    kernel = kernel_of(line_transfer(7.0, angle_deg), reach_px=3.5)
    assert contrast_left(kernel, 0.08, angle_deg) == pytest.approx(np.sinc(7 * 0.08), abs=0.015)
    assert contrast_left(kernel, 1 / 7, angle_deg) == pytest.approx(0.0, abs=0.015)
    assert contrast_left(kernel, 0.1, angle_deg + 90) == pytest.approx(1.0, abs=0.015)


def test_diffraction_leaves_nothing_beyond_its_cut_off():
    kernel = kernel_of(airy_transfer(0.25), reach_px=32)
    half = 2 / np.pi * (np.arccos(0.5) - 0.5 * np.sqrt(0.75))
    assert contrast_left(kernel, 0.125) == pytest.approx(half, abs=0.01)
    assert contrast_left(kernel, 0.3) == pytest.approx(0.0, abs=0.01)


@given(st.floats(0.01, 20.0), st.floats(0.0, 180.0))
@settings(max_examples=25, deadline=None)
def test_kernels_are_symmetric_and_keep_the_light(size_px, angle_deg):
    kernel = kernel_of(line_transfer(size_px, angle_deg), reach_px=size_px)
    assert kernel.sum() == pytest.approx(1.0)
    np.testing.assert_allclose(kernel, kernel[::-1, ::-1], atol=1e-12)


def test_a_blur_makes_no_light_and_no_darkness():
    spot = np.zeros((1, 32, 32, 3), np.float32)
    spot[:, 16, 16] = 1000
    blurred = blur(spot, kernel_of(gaussian_transfer(0.3), reach_px=2))
    assert blurred.dtype == np.float32
    assert blurred.min() >= 0
    assert blurred.max() <= 1000
