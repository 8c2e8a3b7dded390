"""Effects that scale or spread light: exposure, uneven light, glare, flicker, metering."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from pydantic import ValidationError

from tacos_framework.testing.forming import placed, with_effect
from tacos_framework.testing.samples import sample_capture
from tacos_framework.values import ContextMissing, Exposure, ImageContext
from tacos_plugins.effects.auto_exposure import AutoExposure
from tacos_plugins.effects.exposure_error import ExposureError
from tacos_plugins.effects.flicker import Flicker
from tacos_plugins.effects.illumination_gradient import IlluminationGradient
from tacos_plugins.effects.row_waves import common_wave
from tacos_plugins.effects.veiling_glare import VeilingGlare
from tests.effects.light_arrays import GEOMETRY, light, run

FLAT = np.full((1, 72, 96, 3), 8.0)


def test_an_exposure_error_scales_all_light():
    np.testing.assert_allclose(run(ExposureError, light(), scale=1.4), 1.4 * light())


def test_uneven_light_rises_by_its_gradient_from_edge_to_edge():
    field = run(IlluminationGradient, FLAT, gx=0.2, gy=-0.1)[0, :, :, 0] / 8.0
    assert field.mean() == pytest.approx(1.0)
    np.testing.assert_allclose(np.diff(field, axis=1), 0.2 / 96)
    np.testing.assert_allclose(np.diff(field, axis=0), -0.1 / 72)


def test_a_crop_lies_in_the_light_of_the_whole_sensor():
    crop = GEOMETRY.crop(x=50, y=30, width_px=20, height_px=30)
    whole = run(IlluminationGradient, FLAT, gx=0.2, gy=0.3)
    part = run(IlluminationGradient, FLAT[:, 30:60, 50:70], gx=0.2, gy=0.3, geometry=crop)
    np.testing.assert_allclose(part, whole[:, 30:60, 50:70])


def test_light_is_never_negative():
    assert run(IlluminationGradient, FLAT, gx=2.0, gy=2.0).min() == 0.0


@pytest.mark.parametrize("spread", [None, 0.3])
def test_glare_lifts_the_dark_and_keeps_the_mean(spread):
    scene = np.zeros((2, 72, 96, 3))
    scene[0, :, 48:] = 10.0
    veiled = run(VeilingGlare, scene, share=0.04, spread=spread)
    np.testing.assert_allclose(veiled.mean(axis=(1, 2)), scene.mean(axis=(1, 2)), rtol=1e-6, atol=1e-12)
    if spread is None:
        np.testing.assert_allclose(veiled[0, :, :48], 0.04 * 5.0)
    else:  # nearer to the light there is more of it
        assert veiled[0, 36, 46, 0] > 2 * veiled[0, 36, 2, 0] > 0
    assert not veiled[1].any()  # with the cap on


def test_stray_light_keeps_its_colour():
    scene = np.zeros((1, 72, 96, 3))
    scene[0, :30, :, 0] = 10.0
    veiled = run(VeilingGlare, scene, share=0.1)
    assert veiled[0, 60, 50, 0] > 0
    assert not veiled[..., 1:].any()


def test_flicker_is_a_wave_over_the_rows_whose_phase_moves():
    frames = np.repeat(FLAT, 6, axis=0)
    waves = run(Flicker, frames, depth=0.2, period_rows=24.0)[:, :, 10, 0] / 8.0
    spectra = np.fft.rfft(waves, axis=1) / 72
    np.testing.assert_allclose(np.abs(spectra[:, 3]), 0.1, rtol=1e-9)  # three periods in 72 rows
    np.testing.assert_allclose(np.abs(np.delete(spectra, [0, 3], axis=1)), 0, atol=1e-12)
    assert np.ptp(np.angle(spectra[:, 3])) > 1.0
    assert not run(Flicker, np.zeros_like(frames), depth=0.2).any()


@pytest.mark.parametrize("period_rows", [41.0, 113.8, 190.0])
def test_frames_that_differ_by_a_lamp_tell_its_period_and_depth(period_rows):
    """Also where a wave is longer than the picture, beside an expectation that is wrong in every frame."""
    rng = np.random.default_rng(8)
    rows = np.arange(120)
    groups = []
    for _ in range(5):
        phases = rng.uniform(0, 2 * np.pi, (4, 1))
        wrong = 0.3 * rng.standard_normal(120)
        lamp = 0.08 * np.sin(2 * np.pi * rows / period_rows + phases)
        groups.append(wrong + lamp + 0.003 * rng.standard_normal((4, 120)))
    periods = [32 * 120 / k for k in range(8, 900)]
    found = common_wave(groups, periods)
    assert found.period == pytest.approx(period_rows, rel=0.03)
    assert found.amplitude == pytest.approx(0.08, rel=0.2)  # by the luck of the phases
    assert found.share > 0.9


def test_frames_that_differ_by_noise_share_no_wave():
    rng = np.random.default_rng(9)
    groups = [rng.standard_normal((4, 120)) for _ in range(5)]
    assert common_wave(groups, [32 * 120 / k for k in range(8, 900)]).share < 0.2


def test_flicker_counts_the_rows_of_the_sensor():
    crop = GEOMETRY.crop(x=0, y=31, width_px=96, height_px=40)
    whole = run(Flicker, FLAT, depth=0.2, period_rows=17.0, seed=4)
    part = run(Flicker, FLAT[:, 31:71], depth=0.2, period_rows=17.0, seed=4, geometry=crop)
    np.testing.assert_allclose(part, whole[:, 31:71])


def metered(luminance, **settings):
    frames = np.ones((len(luminance), 6, 8, 3)) * np.reshape(luminance, (-1, 1, 1, 1))
    context = ImageContext(exposure_s=0.03, f_number=2.0)
    exposed = run(AutoExposure, frames, context=context, **settings)
    mlx_s = 1e3 * exposed[:, 0, 0, 1] * math.pi * 0.03 / (4 * 2.0**2)
    return mlx_s, exposed[:, 0, 0, 0] / np.asarray(luminance)


def test_metering_takes_every_frame_to_the_target():
    mlx_s, _ = metered([1.0, 2.0, 5.0], target_mlx_s=10.0)
    np.testing.assert_allclose(mlx_s, 10.0)


def test_metering_stops_at_its_limits():
    _, factors = metered([1e-4, 1e4], target_mlx_s=10.0, shortest=0.1, longest=3.0)
    np.testing.assert_allclose(factors, [3.0, 0.1])


def test_metering_lags_behind_a_change_of_light():
    _, factors = metered([2.0] + [8.0] * 5, target_mlx_s=10.0, lag_frames=2.0)
    stops = np.log2(factors / factors[0])
    np.testing.assert_allclose(stops, -2 * (1 - np.exp(-np.arange(6) / 2)), atol=1e-12)


def test_metering_weighs_colours_by_luminance():
    green = np.zeros((1, 6, 8, 3))
    green[..., 1] = 4.0
    context = ImageContext(exposure_s=0.03, f_number=2.0)
    exposed = run(AutoExposure, green, context=context, target_mlx_s=1.0)
    assert exposed[0, 0, 0, 1] * 0.7152 * math.pi * 0.03 / 16 * 1e3 == pytest.approx(1.0)


def test_metering_against_the_first_frame_evens_out_a_share_of_a_change():
    _, factors = metered([2.0, 8.0, 1.0], strength=0.5)
    np.testing.assert_allclose(factors, [1.0, 0.5, 2**0.5])
    _, factors = metered([2.0, 8.0], strength=1.0, shortest=0.5)
    np.testing.assert_allclose(factors, [1.0, 0.5])


def test_a_camera_that_has_not_settled_comes_to_its_exposure():
    _, factors = metered([2.0] * 5, first=4.0, lag_frames=2.0)
    np.testing.assert_allclose(np.log2(factors), 2 * np.exp(-np.arange(5) / 2))


def test_metering_refuses_what_it_cannot_do():
    with pytest.raises(ContextMissing, match="f-number"):
        run(AutoExposure, FLAT, target_mlx_s=10.0)
    with pytest.raises(ValidationError, match="above longest"):
        AutoExposure.Config(shortest=5.0, longest=2.0)


def test_metering_goes_on_from_frame_to_frame_of_an_episode():
    """Frames come one by one: what the effect remembers makes them the same as all at once."""
    light = [2.0, 8.0, 8.0, 3.0]
    _, together = metered(light, target_mlx_s=10.0, lag_frames=2.0)
    effect = AutoExposure(AutoExposure.Config(target_mlx_s=10.0, lag_frames=2.0))
    context = ImageContext(exposure_s=0.03, f_number=2.0)
    one_by_one = [effect.factors(np.full((1, 6, 8, 3), each), context)[0] for each in light]
    np.testing.assert_allclose(one_by_one, together)
    capture = sample_capture(frames=4)
    views = tuple(
        replace(v, luminance_cd_m2=v.luminance_cd_m2 * np.array(light)[:, None, None, None])
        for v in capture.views
    )
    lagging = placed(AutoExposure, target_mlx_s=10.0, lag_frames=2.0)
    exposed = with_effect(replace(capture, views=views), lagging, exposure=Exposure(0.03, 2.0, 0.0))
    means = exposed.views[0].luminance_cd_m2.mean((1, 2, 3))
    stops = np.log2(means / means[0])
    assert stops[1] == pytest.approx(2 - 2 * (1 - math.exp(-0.5)), abs=0.05)
