"""Photons, electrons and what noise they leave: EMVA 1288 in small."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tacos_plugins.sensors.electrons import (
    PHOTONS_PER_LUX_S_UM2,
    count_electrons,
    photon_transfer_variance,
    photons_per_luminance,
    system_gain,
)

PLANCK_J_S, LIGHT_M_S = 6.62607015e-34, 299792458.0


def counted(expected_e: float, *, seed: int = 1, size: int = 200_000, **settings) -> np.ndarray:
    settings = {"full_well_e": 1e5, "read_noise_e": 0.0, **settings}
    return count_electrons(np.full(size, expected_e), rng=np.random.default_rng(seed), **settings)


def test_photons_per_lux_follow_from_the_tables_of_the_cie():
    import colour

    shape = colour.SpectralShape(360, 830, 1)
    daylight = colour.SDS_ILLUMINANTS["D65"].copy().align(shape)
    eye = colour.colorimetry.SDS_LEFS["CIE 1924 Photopic Standard Observer"].copy().align(shape)
    wavelength_m = daylight.wavelengths * 1e-9
    photons = daylight.values * wavelength_m / (PLANCK_J_S * LIGHT_M_S)
    seen = (daylight.wavelengths >= 400) & (daylight.wavelengths <= 700)
    per_lux_s_um2 = 1e-12 * photons[seen].sum() / (683.002 * (daylight.values * eye.values).sum())
    assert PHOTONS_PER_LUX_S_UM2["daylight"] == pytest.approx(per_lux_s_um2, rel=1e-5)
    at_555 = 1e-12 * 555e-9 / (PLANCK_J_S * LIGHT_M_S) / 683.002
    assert PHOTONS_PER_LUX_S_UM2["green-555nm"] == pytest.approx(at_555, rel=1e-5)


@given(
    time_s=st.floats(1e-4, 1.0),
    f_number=st.floats(0.9, 22.0),
    pixel_um=st.floats(0.8, 10.0),
    factor=st.floats(1.1, 4.0),
)
def test_photons_follow_time_area_and_aperture(time_s, f_number, pixel_um, factor):
    one = photons_per_luminance(time_s=time_s, f_number=f_number, pixel_um=pixel_um)
    assert photons_per_luminance(
        time_s=factor * time_s, f_number=f_number, pixel_um=pixel_um
    ) == pytest.approx(factor * one)
    assert photons_per_luminance(
        time_s=time_s, f_number=factor * f_number, pixel_um=pixel_um
    ) == pytest.approx(one / factor**2)
    assert photons_per_luminance(
        time_s=time_s, f_number=f_number, pixel_um=factor * pixel_um
    ) == pytest.approx(one * factor**2)


@pytest.mark.parametrize("expected_e", [0.5, 30.0, 4000.0])
def test_counts_are_poisson(expected_e):
    read = counted(expected_e)
    assert np.all(read == np.rint(read))
    assert read.mean() == pytest.approx(expected_e, abs=5 * math.sqrt(expected_e / read.size))
    assert read.var() == pytest.approx(expected_e, rel=0.025)
    skew = np.mean((read - read.mean()) ** 3) / read.std() ** 3
    assert skew == pytest.approx(1 / math.sqrt(expected_e), abs=0.06)


def test_read_noise_adds_to_the_variance_and_not_to_the_mean():
    read = counted(100.0, read_noise_e=6.0)
    assert read.mean() == pytest.approx(100.0, abs=0.15)
    assert read.var() == pytest.approx(136.0, rel=0.02)


def test_nothing_beyond_the_full_well():
    assert counted(500.0, full_well_e=300.0).max() == 300.0
    assert counted(500.0, full_well_e=300.0).std() == 0.0


def test_averaging_photosites_divides_the_variance():
    one, nine = (counted(200.0, read_noise_e=5.0, photosites=n) for n in (1, 9))
    assert nine.mean() == pytest.approx(one.mean(), abs=0.2)
    assert one.var() / nine.var() == pytest.approx(9, rel=0.03)


@pytest.mark.parametrize("scale", [0.0, 0.25, 3.0])
def test_photon_noise_can_be_scaled_without_touching_the_mean(scale):
    read = counted(400.0, photon_scale=scale)
    assert read.mean() == pytest.approx(400.0, abs=0.5)
    assert read.var() == pytest.approx(400.0 * scale, rel=0.03)


def test_what_is_read_is_as_narrow_as_samples_are():
    assert counted(100.0, size=2, read_noise_e=1.0).dtype == np.float32


def test_an_offset_below_zero_is_kept_without_counts():
    assert set(counted(-3.0)) == {-3.0}


@given(
    signal_dn=st.floats(0.0, 4000.0),
    gain=st.floats(0.01, 5.0),
    read_noise_e=st.floats(0.0, 30.0),
    photosites=st.floats(1.0, 64.0),
)
def test_the_photon_transfer_is_affine_with_the_gain_as_its_slope(signal_dn, gain, read_noise_e, photosites):
    at_zero, at_signal = photon_transfer_variance([0.0, signal_dn], gain, read_noise_e, photosites=photosites)
    assert at_zero * photosites == pytest.approx((gain * read_noise_e) ** 2)
    assert (at_signal - at_zero) * photosites == pytest.approx(gain * signal_dn, abs=1e-9)


def test_variances_keep_double_precision_whatever_they_come_from():
    signal = np.float32([100.3])
    assert photon_transfer_variance(signal, 0.3, 4.0)[0] == pytest.approx(
        0.3 * float(signal[0]) + 1.44, rel=1e-15
    )


def test_the_full_well_fills_the_range_at_0_db():
    assert system_gain(8180, 4095, gain_db=0.0) * 8180 == pytest.approx(4095)
    assert system_gain(8180, 4095, gain_db=6.0) * 8180 == pytest.approx(4095 * 10**0.3)
