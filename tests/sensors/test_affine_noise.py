"""The sensor from light to files: brightness, noise, binning, rounding, clipping."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import ClassVar

import numpy as np
import pytest
from toy_plugin import Dim

from tacos_framework.errors import UserError
from tacos_framework.settings import Settings
from tacos_framework.testing.forming import expose as exposed
from tacos_framework.testing.forming import placed
from tacos_framework.values import Camera, Capture, Exposure
from tacos_plugins.sensors.affine_noise import AffineNoise
from tests.small_worlds import captured_light

DAY = Exposure(time_s=0.030, f_number=2.0, gain_db=5.0)
WHITE_WALL_AT_20_LUX = 0.8 * 20 / math.pi  # cd/m2


def even_light(
    luminance_cd_m2: float, *, pixel_um: float = 1.55, binning: float = 1.0, frames: int = 2
) -> Capture:
    camera = Camera("camera", 200, 150, pixel_um, focal_length_mm=4.0, binning=binning)
    return captured_light(camera, luminance_cd_m2, frames)


def expose(capture: Capture, exposure: Exposure = DAY, *, seed: int = 1, effects=(), **config) -> np.ndarray:
    sensor = AffineNoise(AffineNoise.Config(**config))
    return exposed(sensor, capture, effects=effects, exposure=exposure, seed=seed).images[0]


def test_a_white_wall_by_day_comes_to_200_of_255():
    assert expose(even_light(WHITE_WALL_AT_20_LUX)).mean() == pytest.approx(200, abs=0.5)


def test_brightness_follows_light_time_aperture_and_gain_but_not_the_pitch():
    light = WHITE_WALL_AT_20_LUX / 4
    reference = expose(even_light(light)).mean()
    assert reference == pytest.approx(50, abs=0.2)
    for capture, exposure in [
        (even_light(2 * light), DAY),
        (even_light(light), replace(DAY, time_s=0.060)),
        (even_light(light), replace(DAY, f_number=2.0 / math.sqrt(2))),
        (even_light(light), replace(DAY, gain_db=5 + 20 * math.log10(2))),
        (even_light(2 * light, pixel_um=6.0), DAY),
    ]:
        assert expose(capture, exposure).mean() == pytest.approx(2 * reference, abs=0.3)


@pytest.mark.parametrize("pixel_um", [1.55, 3.45])
@pytest.mark.parametrize("gain_db", [5.0, 15.0])
@pytest.mark.parametrize("binning", [1.0, 2.0])
def test_noise_has_the_variance_of_the_model_and_that_of_rounding(pixel_um, gain_db, binning):
    exposure = replace(DAY, gain_db=gain_db)
    light = WHITE_WALL_AT_20_LUX / 2 * 10 ** ((5 - gain_db) / 20)  # mid grey at any gain
    # More bits, so that rounding is fine against the noise and its error is white.
    image = expose(even_light(light, pixel_um=pixel_um, binning=binning), exposure, bit_depth=12)
    ratio = (1.55 / pixel_um) ** 2 * 10 ** ((gain_db - 15) / 20)
    expected = [
        (ratio * photon * 100 + ratio**2 * thermal) / binning**2
        for photon, thermal in zip((0.24, 0.12, 0.29), (1.82, 0.91, 3.2), strict=True)
    ]
    measured = image.var((0, 1, 2)) / 16**2 - 1 / 12 / 16**2
    np.testing.assert_allclose(measured, expected, rtol=0.03)


@pytest.mark.parametrize(("pixel_um", "snr_db"), [(1.55, 35.2), (3.45, 42.2), (6.6, 47.9)])
def test_snr_of_green_at_half_scale(pixel_um, snr_db):
    light = WHITE_WALL_AT_20_LUX * 128 / 200
    green = expose(even_light(light, pixel_um=pixel_um), bit_depth=14)[..., 1]
    assert 20 * math.log10(green.mean() / green.std()) == pytest.approx(snr_db, abs=0.1)


def test_simulated_binning_equals_averaging_real_photosites():
    fine = expose(even_light(1.0, frames=8), bit_depth=14).astype(float)
    blocks = fine.reshape(8, 75, 2, 100, 2, 3).mean((2, 4))
    coarse = expose(even_light(1.0, binning=2.0, frames=2), bit_depth=14)
    np.testing.assert_allclose(coarse.mean((0, 1, 2)), blocks.mean((0, 1, 2)), rtol=1e-3)
    np.testing.assert_allclose(coarse.var((0, 1, 2)), blocks.var((0, 1, 2)), rtol=0.04)


def test_files_are_rounded_not_truncated():
    """At 8 bits and 5 dB noise is below one digital number: truncation would show as half of one."""
    levels = [expose(even_light(WHITE_WALL_AT_20_LUX * share)).mean() for share in (0.2512, 0.2537, 0.2563)]
    np.testing.assert_allclose(levels, [50.24, 50.74, 51.26], atol=0.02)


def test_darkness_without_a_pedestal_loses_half_of_its_noise():
    """A Gaussian clipped at zero keeps sigma / sqrt(2 pi) as its mean."""
    exposure = replace(DAY, gain_db=35.0)
    sigma = 10 * np.sqrt([1.82, 0.91, 3.2])
    clipped = expose(even_light(0.0), exposure)
    np.testing.assert_allclose(clipped.mean((0, 1, 2)), sigma / math.sqrt(2 * math.pi), rtol=0.02)
    kept = expose(even_light(0.0), exposure, black_level_dn=100.0)
    np.testing.assert_allclose(kept.mean((0, 1, 2)), 100.0, atol=0.4)
    np.testing.assert_allclose(kept.std((0, 1, 2)), sigma, rtol=0.02)


def test_too_much_light_clips_at_the_white_level():
    assert set(np.unique(expose(even_light(100.0)))) == {255}
    assert set(np.unique(expose(even_light(100.0), bit_depth=12))) == {4095}


def test_more_bits_measure_the_same_light_more_finely():
    eight = expose(even_light(2.0), black_level_dn=8.0).astype(float) - 8
    twelve = expose(even_light(2.0), bit_depth=12, black_level_dn=128.0).astype(float) - 128
    assert twelve.mean() / eight.mean() == pytest.approx(16, rel=1e-3)


def test_effects_before_the_noise_leave_it_white_and_those_after_do_not():
    class Smooth:
        class Config(Settings):
            pass

        stage = "pixel"
        neutral: ClassVar = {}

        def __init__(self, config):
            pass

        def on_array(self, samples, **supplied):
            return (samples + np.roll(samples, 1, axis=2)) / 2

    class SmoothAfterwards(Smooth):
        stage = "readout"

    def neighbours(effect) -> float:
        noise = expose(even_light(1.0), effects=[placed(effect)], bit_depth=12)[..., 1].astype(float)
        noise -= noise.mean()
        return float(np.mean(noise[:, :, 1:] * noise[:, :, :-1]) / noise.var())

    assert neighbours(Smooth) == pytest.approx(0.0, abs=0.02)
    assert neighbours(SmoothAfterwards) == pytest.approx(0.5, abs=0.02)


def test_the_memory_layout_an_effect_leaves_does_not_matter():
    class Reordered(Dim):
        def on_array(self, samples, **supplied):
            return np.asfortranarray(samples)

    np.testing.assert_array_equal(
        expose(even_light(1.0), effects=[placed(Reordered)]), expose(even_light(1.0))
    )


def test_the_gain_is_the_slope_of_a_photosites_photon_noise():
    """Green of the calibrated photosite at the calibrated gain: s_p itself, whatever the binning."""
    sensor, exposure = AffineNoise(AffineNoise.Config()), replace(DAY, gain_db=15.0)
    camera = even_light(1.0, binning=3.0).views[0].camera
    assert sensor.dn_per_electron(camera, exposure) == pytest.approx(0.12, rel=1e-6)
    twice = replace(camera, pixel_um=camera.pixel_um * math.sqrt(2))
    assert sensor.dn_per_electron(twice, exposure) == pytest.approx(0.06, rel=1e-6)


def test_a_calibration_of_one_channel_gives_mono_images():
    calibration = {
        "title": "A mono camera",
        "source": "test",
        "sensor": "any",
        "pixel_um": 3.0,
        "exposure_ms": 10,
        "gain_db": 0,
        "bit_depth": 10,
        "photon_dn": [0.1],
        "thermal_dn2": [4.0],
        "responsivity_dn_per_lux_s": 10_000,
    }
    image = expose(even_light(1.0, pixel_um=3.0), replace(DAY, gain_db=0.0), calibration=calibration)
    signal = 10_000 * math.pi * 0.030 / 16
    assert image.shape == (2, 150, 200, 1)
    assert image.dtype == np.uint16
    assert image.mean() == pytest.approx(signal, rel=1e-3)
    assert image.var() == pytest.approx(0.1 * signal + 4 + 1 / 12, rel=0.03)


def test_a_pedestal_above_the_white_level_is_refused():
    with pytest.raises(UserError, match="black_level_dn is 300") as raised:
        AffineNoise(AffineNoise.Config(black_level_dn=300.0))
    assert "255 DN at 8 bit" in str(raised.value)


def test_an_unknown_calibration_is_refused():
    with pytest.raises(UserError, match="flea4"):
        AffineNoise(AffineNoise.Config(calibration="flea4"))
