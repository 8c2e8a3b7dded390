"""Light on the sensor, and the way to file values."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tacos_framework.camera.exposure import (
    exposure_per_luminance,
    gain_factor,
)
from tacos_framework.formation.arrays import digitise


def test_a_grey_card_in_full_sun_at_the_sunny_16_setting():
    """For a matte surface pi cancels: H = reflectance * illuminance * time / (4 N^2)."""
    luminance = 100_000.0 * 0.18 / np.pi
    by_hand = 0.18 * 100_000 * 0.01 / (4 * 16**2)
    assert luminance * exposure_per_luminance(1 / 100, 16.0) == pytest.approx(by_hand)
    assert by_hand == pytest.approx(0.176, abs=5e-4)


@given(st.floats(1e-4, 1.0), st.floats(1.0, 22.0))
def test_a_stop_halves_the_light(time_s, f_number):
    full = exposure_per_luminance(time_s, f_number)
    assert exposure_per_luminance(time_s / 2, f_number) == pytest.approx(full / 2)
    assert exposure_per_luminance(time_s, f_number * 2**0.5) == pytest.approx(full / 2)


def test_six_decibel_double_the_signal():
    assert gain_factor(6.0206) == pytest.approx(2.0, rel=1e-5)


@pytest.mark.parametrize(
    ("white", "dtype"),
    [(1, np.uint8), (255, np.uint8), (256, np.uint16), (4095, np.uint16), (65535, np.uint16)],
)
def test_files_are_as_narrow_as_the_white_level_allows(white, dtype):
    samples = np.float32([-1e9, 0, white, 1e9])
    digital = digitise(samples, white)
    assert digital.dtype == dtype
    assert digital.tolist() == [0, 0, white, white]


def test_rounding_has_no_bias():
    """Truncation would darken by half a digital number; rounding halves up by nothing only on average."""
    samples = np.random.default_rng(1).uniform(20, 230, 1_000_000).astype(np.float32)
    error = digitise(samples, 255) - samples
    assert abs(error.mean()) < 0.001
    assert error.var() == pytest.approx(1 / 12, rel=0.01)
    halves = np.arange(0.5, 200, 1, dtype=np.float32)
    assert np.mean(digitise(halves, 255) - halves) == 0


def test_the_samples_are_left_as_they_were():
    samples = np.float32([1.4, 300.0])
    digitise(samples, 255)
    assert samples.tolist() == pytest.approx([1.4, 300.0])
