"""The noise model against figures worked out by hand, and the drawn noise against the model."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tacos_plugins.sensors.noise import add_noise, affine_variance, gain_ratio, signal_to_noise_db

FLEA3_GREEN = {"photon_dn": 0.12, "thermal_dn2": 0.91}


def flea3_ratio(gain_db: float, pixel_um: float) -> float:
    return gain_ratio(gain_db, pixel_um, calibrated_gain_db=15.0, calibrated_pixel_um=1.55)


def noisy_of(
    samples: np.ndarray, *, black_level_dn: float = 0.0, photon_dn: Any, thermal_dn2: Any, seed: int
) -> np.ndarray:
    noisy = np.empty_like(samples)
    add_noise(
        samples,
        noisy,
        black_level_dn=black_level_dn,
        photon_dn=np.float32(photon_dn),
        thermal_dn2=np.float32(thermal_dn2),
        rng=np.random.default_rng(seed),
    )
    return noisy


def test_at_the_calibrated_setting_the_model_is_the_calibration():
    assert flea3_ratio(15.0, 1.55) == 1.0
    assert affine_variance(100.0, **FLEA3_GREEN) == pytest.approx(0.12 * 100 + 0.91)


@pytest.mark.parametrize(("pixel_um", "snr_db"), [(1.55, 35.2), (3.45, 42.2), (6.6, 47.9)])
def test_green_snr_at_half_scale_and_5_db(pixel_um, snr_db):
    variance = affine_variance(128.0, **FLEA3_GREEN, ratio=flea3_ratio(5.0, pixel_um))
    assert signal_to_noise_db(128.0, variance) == pytest.approx(snr_db, abs=0.05)


@pytest.mark.parametrize(
    ("gain_db", "ratio", "variance"),
    [
        (12.0, 0.70795, 0.70795 * 0.12 * 80 + 0.50119 * 0.91),  # the supplement's 20 ms, 12 dB
        (6.0, 0.35481, 0.35481 * 0.12 * 80 + 0.12589 * 0.91),  # and 40 ms, 6 dB
    ],
)
def test_generalisation_to_other_gains(gain_db, ratio, variance):
    assert flea3_ratio(gain_db, 1.55) == pytest.approx(ratio, rel=1e-4)
    assert affine_variance(80.0, **FLEA3_GREEN, ratio=flea3_ratio(gain_db, 1.55)) == pytest.approx(
        variance, rel=1e-4
    )


@given(
    signal_dn=st.floats(0, 255),
    scale=st.floats(0.1, 10),
    ratio=st.floats(0.01, 10),
)
def test_a_gain_scales_signal_and_noise_of_the_same_light_alike(signal_dn, scale, ratio):
    """Both sides of eq. 1 describe one exposure: amplify it by g, and its variance grows by g^2."""
    before = affine_variance(signal_dn, **FLEA3_GREEN, ratio=ratio)
    after = affine_variance(scale * signal_dn, **FLEA3_GREEN, ratio=scale * ratio)
    np.testing.assert_allclose(after, scale**2 * before)


@given(binning=st.integers(1, 8), signal_dn=st.floats(0, 255))
def test_binning_averages_independent_photosites(binning, signal_dn):
    one = affine_variance(signal_dn, **FLEA3_GREEN)
    binned = affine_variance(signal_dn, **FLEA3_GREEN, photosites=binning**2)
    np.testing.assert_allclose(binned, one / binning**2)


def test_signal_below_black_has_the_noise_of_black():
    assert affine_variance(-5.0, **FLEA3_GREEN) == affine_variance(0.0, **FLEA3_GREEN)


@pytest.mark.parametrize("signal_dn", [0.0, 20.0, 200.0])
def test_drawn_noise_has_no_bias_and_the_variance_of_the_model(signal_dn):
    samples = np.full((400, 400, 3), 16.0 + signal_dn, np.float32)
    photon, thermal = np.float32([0.24, 0.12, 0.29]), np.float32([1.82, 0.91, 3.2])
    noisy = noisy_of(samples, black_level_dn=16.0, photon_dn=photon, thermal_dn2=thermal, seed=3)
    expected = photon * signal_dn + thermal
    count = samples.shape[0] * samples.shape[1]
    np.testing.assert_array_less(abs(noisy.mean((0, 1)) - samples[0, 0]), 5 * np.sqrt(expected / count))
    np.testing.assert_allclose(noisy.var((0, 1)), expected, rtol=5 * math.sqrt(2 / count))


def test_drawn_noise_is_gaussian_and_independent_between_pixels_and_channels():
    samples = np.full((300, 300, 3), 100.0, np.float32)
    noisy = noisy_of(samples, photon_dn=0.1, thermal_dn2=0.0, seed=4)
    z = (noisy - 100) / np.sqrt(10)
    assert abs(np.mean(z**3)) < 0.03
    assert np.mean(z**4) == pytest.approx(3.0, abs=0.06)
    neighbours = [np.mean(z[1:] * z[:-1]), np.mean(z[:, 1:] * z[:, :-1]), np.mean(z[..., 1:] * z[..., :-1])]
    np.testing.assert_allclose(neighbours, 0, atol=0.015)


def test_drawn_noise_below_black_is_that_of_black():
    samples = np.full((300, 300, 3), 6.0, np.float32)
    noisy = noisy_of(samples, black_level_dn=16.0, photon_dn=0.24, thermal_dn2=4.0, seed=5)
    assert noisy.var() == pytest.approx(4.0, rel=5 * math.sqrt(2 / samples.size))


def test_variances_keep_double_precision_whatever_they_come_from():
    signal, photon, thermal = np.float32([100.3]), np.float32([0.12]), np.float32([0.91])
    exact = 0.3 * float(photon[0]) * float(signal[0]) + 0.09 * float(thermal[0])
    assert affine_variance(signal, photon, thermal, ratio=0.3)[0] == pytest.approx(exact, rel=1e-14)


def test_noise_is_not_lost_in_a_copy():
    samples = np.zeros((4, 4, 3), np.float32)
    with pytest.raises(ValueError, match=r"^noise can be written into a contiguous array only$"):
        add_noise(
            samples,
            np.asfortranarray(samples),
            black_level_dn=0.0,
            photon_dn=np.float32(0.1),
            thermal_dn2=np.float32(1.0),
            rng=np.random.default_rng(1),
        )
