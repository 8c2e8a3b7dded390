"""Conversion gain, saturation, crosstalk, read noise, row noise: effects told by the noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import ndimage, stats

from tacos_framework.formation import PlacedEffect
from tacos_framework.testing.forming import expose, placed
from tacos_framework.testing.samples import sample_capture, sample_rig
from tacos_plugins.effects.conversion_gain_error import ConversionGainError
from tacos_plugins.effects.conversion_gain_mode import ConversionGainMode
from tacos_plugins.effects.crosstalk import Crosstalk
from tacos_plugins.effects.read_noise import ReadNoise
from tacos_plugins.effects.row_noise import RowNoise
from tacos_plugins.effects.saturation import Saturation
from tacos_plugins.sensors.affine_noise import AffineNoise
from tests.effects.sample_arrays import flats, make, neighbour_correlation, run

SENSOR = AffineNoise(
    AffineNoise.Config(
        bit_depth=12, black_level_dn=200
    )  # many codes, so that rounding and clipping hide nothing
)


def photon_transfer_slope(*effects: PlacedEffect) -> tuple[float, float, float]:
    """Slope and intercept of variance over mean of green, and the mean over all levels [DN, DN^2, DN]."""
    means, variances = [], []
    for luminance_cd_m2 in (0.5, 2.0, 4.0):
        capture = sample_capture(sample_rig(width_px=80, height_px=60), frames=24, luminance_cd_m2=0.0)
        light = np.full_like(capture.views[0].luminance_cd_m2, luminance_cd_m2)
        even = replace(capture, views=(replace(capture.views[0], luminance_cd_m2=light),))
        green = expose(SENSOR, even, effects=effects, seed=3).images[0][..., 1].astype(float)
        means.append(green.mean() - 200)
        variances.append(green.var(axis=0, ddof=1).mean())
    slope, intercept = np.polyfit(means, variances, 1)
    return slope, intercept, float(np.mean(means))


def test_conversion_gain_scales_the_slope_of_the_photon_transfer_curve_and_keeps_the_mean():
    slope, intercept, mean = photon_transfer_slope()
    scaled_slope, scaled_intercept, scaled_mean = photon_transfer_slope(
        placed(ConversionGainError, scale=1.5)
    )
    assert scaled_slope / slope == pytest.approx(1.5, rel=0.02)  # the same draws: the ratio is nearly exact
    assert scaled_mean == pytest.approx(mean, abs=0.05)
    assert scaled_intercept == pytest.approx(intercept, abs=0.05 * slope * mean)


def test_conversion_gains_multiply_and_leave_samples_alone():
    assert make(ConversionGainError, scale=1.5).photon_scale == 1.5
    one, two = placed(ConversionGainError, scale=1.5), placed(ConversionGainError, scale=2.0)
    slope, _, _ = photon_transfer_slope()
    assert photon_transfer_slope(one, two)[0] / slope == pytest.approx(3.0, rel=0.04)
    frames = flats()
    assert run(make(ConversionGainError, scale=1.5), frames) is frames


@pytest.mark.parametrize(("from_db", "scale"), [(0.0, 0.6), (50.0, 1.0)])
def test_a_mode_changes_the_noise_without_light_from_its_gain_on(from_db, scale):
    slope, intercept, mean = photon_transfer_slope()
    other = photon_transfer_slope(placed(ConversionGainMode, from_db=from_db, noise_scale=0.6))
    assert other[0] / slope == pytest.approx(1.0, rel=0.02)
    dark_dn2 = intercept - 1 / 12  # of rounding
    assert other[1] - intercept == pytest.approx((scale**2 - 1) * dark_dn2, abs=0.05 * intercept)
    assert other[2] == pytest.approx(mean, abs=0.05)


def test_noise_after_the_gain_adds_to_that_before_it():
    seen = run(make(ReadNoise, sigma_dn=3.0, after_gain_dn=4.0), flats(100.0, 0.0))
    assert seen.std() == pytest.approx(5.0, rel=0.02)


def test_saturated_samples_pile_up_at_the_level():
    seen = run(make(Saturation, level_dn=150.0), flats(150.0, 4.0))
    assert seen.max() == 150.0
    assert (seen == 150.0).mean() == pytest.approx(0.5, abs=0.02)
    # A Gaussian cut off at its mean keeps (1 - 1 / pi) / 2 of its variance.
    assert seen.var() == pytest.approx(16 * (1 - 1 / np.pi) / 2, rel=0.03)


@pytest.mark.parametrize("level_dn", [255.0, 300.0])
def test_saturation_at_or_above_the_white_level_is_off(level_dn):
    frames = flats(250.0, 4.0)
    assert run(make(Saturation, level_dn=level_dn), frames) is frames


def test_crosstalk_is_a_correlation_with_equal_neighbours():
    scene = np.random.default_rng(8).uniform(20, 200, (2, 30, 40, 3))
    kernel = np.full((3, 3), 0.04)
    kernel[1, 1] = 1 - 8 * 0.04
    expected = np.stack(
        [
            np.stack([ndimage.correlate(frame[..., c], kernel, mode="reflect") for c in range(3)], axis=-1)
            for frame in scene
        ]
    )
    np.testing.assert_allclose(run(make(Crosstalk, share=0.04), scene), expected, rtol=1e-12)


def test_crosstalk_without_corners_is_shared_by_four():
    scene = np.random.default_rng(9).uniform(20, 200, (1, 30, 40, 1))
    kernel = [[0, 0.03, 0], [0.03, 0.88, 0.03], [0, 0.03, 0]]
    expected = ndimage.correlate(scene[0, ..., 0], kernel, mode="reflect")
    shared = run(make(Crosstalk, share=0.03, corners=0.0), scene)
    np.testing.assert_allclose(shared[0, ..., 0], expected, rtol=1e-12)


def test_crosstalk_correlates_the_noise_of_neighbours_by_about_twice_the_share():
    share = 0.01
    seen = run(make(Crosstalk, share=share), flats(height=200, width=200))
    centre = 1 - 8 * share
    exact = (2 * centre * share + 4 * share**2) / (centre**2 + 8 * share**2)
    assert neighbour_correlation(seen) == pytest.approx(exact, abs=0.005)  # 480,000 samples: error 0.0015
    assert exact == pytest.approx(2 * share, rel=0.15)
    assert seen.mean() == pytest.approx(100.0, abs=0.02)


def test_read_noise_adds_its_variance_at_every_level_and_no_bias():
    effect = make(ReadNoise, sigma_dn=2.0)
    for level_dn in (16.0, 200.0):
        noise = run(effect, flats(level_dn, 0.0, height=200, width=200)) - level_dn
        assert noise.var() == pytest.approx(4.0, rel=0.01)
        assert noise.mean() == pytest.approx(0.0, abs=0.015)
        assert neighbour_correlation(noise) == pytest.approx(0.0, abs=0.006)


def test_tails_are_those_of_students_t_at_the_same_variance():
    noise = run(make(ReadNoise, sigma_dn=2.0, tail=0.2), flats(0.0, 0.0, height=100, width=200))
    student = stats.t(df=5, scale=2.0 / np.sqrt(5 / 3))
    assert stats.kstest(noise.ravel(), student.cdf).pvalue > 0.01
    assert noise.var() == pytest.approx(4.0, rel=0.05)


@pytest.mark.parametrize("tail", [0.1, 0.15])
def test_the_mean_of_photosites_has_lighter_tails(tail):
    noise = run(make(ReadNoise, sigma_dn=2.0, tail=tail), flats(0.0, 0.0, height=300, width=400), binning=3.0)
    expected = 6 * tail / (1 - 4 * tail) / 9
    assert stats.kurtosis(noise.ravel()) == pytest.approx(expected, rel=0.2)


def test_row_noise_is_common_to_a_row_and_new_in_every_frame():
    noise = run(make(RowNoise, sigma_dn=1.5), flats(0.0, 0.0, frames=50, height=200, width=20))
    rows = noise[:, :, 0, 0]
    np.testing.assert_array_equal(noise, np.broadcast_to(rows[:, :, None, None], noise.shape))
    assert rows.var() == pytest.approx(1.5**2, rel=0.06)  # 10,000 rows: standard error 1.4 %
    assert np.corrcoef(rows[0], rows[1])[0, 1] == pytest.approx(0.0, abs=0.25)


def test_column_noise_is_common_to_a_column():
    noise = run(make(RowNoise, column_sigma_dn=0.5), flats(0.0, 0.0, frames=50, height=20, width=200))
    columns = noise[:, 0, :, 0]
    np.testing.assert_array_equal(noise, np.broadcast_to(columns[:, None, :, None], noise.shape))
    assert columns.var() == pytest.approx(0.25, rel=0.06)
