"""Injected effects of the sensor and of processing change what physics says they change."""

from __future__ import annotations

import numpy as np
import pytest

from tacos_validation.blind.generators import light_effects as light
from tacos_validation.blind.generators import processing_effects as processing
from tacos_validation.blind.generators import sensor_effects as sensor
from tacos_validation.blind.generators.camera import IdealShot, dark
from tacos_validation.blind.generators.injected_effect import InjectedEffect
from tests.validation.blind.ideal_frames import COLOUR, MONO, difference, flat, frames


def test_conversion_gain_changes_noise_but_not_the_mean() -> None:
    clean, noisy = frames(flat(), count=16), frames(flat(), sensor.InjectedConversionGainError(2.0), count=16)
    assert noisy.mean() == pytest.approx(clean.mean(), abs=0.15)
    assert noisy.var(axis=0).mean() > 1.8 * clean.var(axis=0).mean()


@pytest.mark.parametrize(
    "effect", [sensor.InjectedPrnu(0.03), sensor.InjectedDsnu(3.0)], ids=lambda f: f.name
)
def test_fixed_patterns_repeat_over_frames_and_captures(effect: InjectedEffect) -> None:
    one = frames(flat(level=0.6), effect, count=8, seed=1).mean(axis=0)
    other = frames(flat(level=0.5), effect, count=8, seed=2).mean(axis=0)
    assert np.corrcoef(one.ravel(), other.ravel())[0, 1] > 0.5


def test_dark_current_grows_with_time_in_the_same_pixels() -> None:
    effect = sensor.InjectedDarkCurrent(rate_dn_s=20.0, hot_share=0.002)
    short, long = (frames(IdealShot(MONO, dark, time), effect).mean(axis=0) for time in (50.0, 200.0))
    assert np.median(long) - np.median(short) == pytest.approx(3.0, abs=0.6)
    hot = long > np.median(long) + 15
    assert 0 < hot.sum() < 0.01 * hot.size
    assert (short[hot] > np.median(short) + 3).mean() > 0.8


def test_bad_lines_stand_off_over_their_whole_length() -> None:
    change = difference(flat(), sensor.InjectedDefectLines(20.0, columns=2, rows=1), count=12)[..., 0]
    assert (np.median(change, axis=0) > 15).sum() == 2
    assert (np.median(change, axis=1) > 15).sum() == 1
    assert abs(np.median(change)) < 1


def test_coupling_correlates_noise_and_blur_does_not() -> None:
    def neighbours(*effects: InjectedEffect) -> float:
        noise = frames(flat(), *effects, count=8)
        noise = noise - noise.mean(axis=0)
        return float((noise[:, 1:] * noise[:, :-1]).mean() / (noise**2).mean())

    assert neighbours(sensor.InjectedCrosstalk(0.03)) > 0.05
    assert abs(neighbours(light.InjectedLensBlur(1.0))) < 0.02


def test_a_full_well_cuts_off_with_a_spike() -> None:
    taken = frames(flat(level=0.8), sensor.InjectedSaturation(200.0))
    assert taken.max() == 200
    assert (taken == 200).mean() > 0.3


def test_a_bent_response_bends() -> None:
    change = [
        difference(flat(level=level), sensor.InjectedNonlinearity(a2=-0.1)).mean() for level in (0.2, 0.8)
    ]
    assert change[0] == pytest.approx(-0.1 * 0.04 * MONO.range_dn, abs=0.4)
    assert change[1] == pytest.approx(-0.1 * 0.64 * MONO.range_dn, abs=0.8)


def test_row_noise_is_there_in_the_dark_and_flicker_is_not() -> None:
    def rows(*effects: InjectedEffect) -> float:
        return float(frames(IdealShot(MONO, dark, 10.0), *effects).mean(axis=2).var(axis=1).mean())

    clean = rows()
    assert rows(sensor.InjectedRowNoise(1.0)) > 5 * clean
    assert rows(light.InjectedFlicker(0.3, 40.0)) < 1.5 * clean


def test_a_pedestal_shifts_the_dark() -> None:
    assert difference(
        IdealShot(MONO, dark, 10.0), sensor.InjectedBlackLevelError(3.0)
    ).mean() == pytest.approx(3, abs=0.15)


def test_coarse_steps_leave_a_comb_and_floor_half_a_code_less() -> None:
    assert (frames(flat(), sensor.InjectedQuantisation(4.0)) % 4 == 0).mean() > 0.99
    floored = difference(flat(), sensor.InjectedQuantisation(1.0, "floor"), count=16)
    assert floored.mean() == pytest.approx(-0.5, abs=0.12)


def test_gains_and_matrices_act_on_colours_alone() -> None:
    grey = flat(COLOUR, level=0.4)
    gained = difference(grey, processing.InjectedWhiteBalance(1.2, 0.9)).mean(axis=(0, 1))
    np.testing.assert_allclose(gained, 0.4 * COLOUR.range_dn * np.array([0.2, 0, -0.1]), atol=0.6)
    matrix = ((1.4, -0.2, -0.2), (-0.1, 1.2, -0.1), (0.0, -0.3, 1.3))
    assert np.abs(difference(grey, processing.InjectedColourMatrix(matrix)).mean(axis=(0, 1))).max() < 0.4


def test_a_mosaic_keeps_even_colours() -> None:
    shot = IdealShot(COLOUR, lambda x, y, c: np.full(x.shape, (90.0, 60.0, 30.0)[c]), 10.0)
    for method in ("bilinear", "edge-aware"):
        filled = frames(shot, processing.InjectedDemosaicing(method), count=16).mean(axis=(0, 1, 2))
        np.testing.assert_allclose(filled, np.array([90.0, 60.0, 30.0]) + COLOUR.black_dn, atol=0.5)


def test_denoising_takes_noise_and_sharpening_adds_it() -> None:
    clean = frames(flat(), count=8).var(axis=0).mean()
    assert frames(flat(), processing.InjectedDenoising(1.0), count=8).var(axis=0).mean() < 0.5 * clean
    assert frames(flat(), processing.InjectedSharpening(0.8), count=8).var(axis=0).mean() > 1.5 * clean


def test_a_display_curve_lifts_shadows() -> None:
    change = difference(flat(level=0.1), processing.InjectedToneCurve(0.5)).mean()
    assert change == pytest.approx((np.sqrt(0.1) - 0.1) * MONO.range_dn, rel=0.05)


def test_jpeg_leaves_a_grid_of_eight() -> None:
    shot = flat()
    taken = frames(shot, processing.InjectedJpeg(30), count=8)
    jumps = np.abs(np.diff(taken, axis=2)).mean(axis=(0, 1, 3))
    assert jumps[7::8].mean() > 2 * np.delete(jumps, np.s_[7::8]).mean()
