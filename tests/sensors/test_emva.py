"""The electron sensor from light to files: brightness, photon transfer, saturation, what must be known."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from toy_plugin import Dim

from tacos_framework.errors import CandidateFailed, UserError
from tacos_framework.testing.forming import expose as exposed
from tacos_framework.testing.forming import placed
from tacos_framework.values import Camera, Capture, Electrons, Exposure
from tacos_plugins.sensors.emva import Emva
from tests.small_worlds import captured_light

KNOWN = Electrons(
    "IMX999", quantum_efficiency=0.6, full_well_e=10_000.0, read_noise_e=3.0, dark_current_e_s=20.0
)
DAY = Exposure(time_s=0.030, f_number=2.0, gain_db=0.0)
ELECTRONS = {"quantum_efficiency": 0.5, "full_well_e": 8000.0, "read_noise_e": 2.0, "dark_current_e_s": 0.0}


def even_light(
    luminance_cd_m2: float,
    *,
    pixel_um: float = 3.0,
    binning: float = 1.0,
    frames: int = 2,
    electrons: Electrons = KNOWN,
) -> Capture:
    camera = Camera("camera", 160, 120, pixel_um, focal_length_mm=4.0, binning=binning, electrons=electrons)
    return captured_light(camera, luminance_cd_m2, frames)


def expose(capture: Capture, exposure: Exposure = DAY, *, seed: int = 1, effects=(), **config) -> np.ndarray:
    sensor = Emva(Emva.Config(**config))
    return exposed(sensor, capture, effects=effects, exposure=exposure, seed=seed).images[0]


def light_for(electrons: float, camera: Camera | None = None, exposure: Exposure = DAY) -> float:
    """Luminance that makes so many electrons in the camera of `even_light` [cd/m2]."""
    camera = camera or even_light(1.0).views[0].camera
    return electrons / Emva(Emva.Config()).electrons_per_luminance(camera, exposure)


def test_electrons_come_from_lux_by_hand():
    """1 cd/m2, f/2, 30 ms: 0.00589 lux s; 10880 photons per lux s and um^2; 9 um^2; 0.6 electrons each."""
    camera = even_light(1.0).views[0].camera
    by_hand = math.pi * 0.030 / 16 * 10880.1 * 9.0 * 0.6
    assert Emva(Emva.Config()).electrons_per_luminance(camera, DAY) == pytest.approx(by_hand)
    image = expose(even_light(10.0), bit_depth=14)
    assert image.mean() * 10_000 / (2**14 - 1) == pytest.approx(10 * by_hand + 20 * 0.030, rel=1e-3)


@settings(max_examples=20, deadline=None)
@given(share=st.floats(0.02, 0.45), factor=st.floats(1.1, 2.0))
def test_the_response_is_linear_in_light_and_time(share, factor):
    electrons = replace(KNOWN, dark_current_e_s=0.0)
    light = light_for(share * 10_000)
    one = expose(even_light(light, electrons=electrons)).mean()
    brighter = expose(even_light(factor * light, electrons=electrons), seed=2).mean()
    longer = expose(
        even_light(light, electrons=electrons), replace(DAY, time_s=factor * 0.030), seed=3
    ).mean()
    tolerance = 6 * math.sqrt(10_000 / 1e5) * 4095 / 10_000
    assert brighter == pytest.approx(factor * one, abs=tolerance)
    assert longer == pytest.approx(factor * one, abs=tolerance)


@pytest.mark.parametrize("gain_db", [0.0, 12.0])
@pytest.mark.parametrize("binning", [1.0, 3.0])
def test_the_photon_transfer_has_the_gain_as_slope_and_the_read_noise_as_intercept(gain_db, binning):
    exposure = replace(DAY, gain_db=gain_db)
    gain = 10 ** (gain_db / 20) * (4095 - 64) / 10_000
    means, variances = [], []
    for electrons in (0, 300, 600, 1200, 2200):
        capture = even_light(light_for(electrons), binning=binning, frames=8)
        image = expose(capture, exposure, black_level_dn=64.0, seed=electrons)
        means.append(image.mean() - 64)
        variances.append(image.var() - 1 / 12)
    slope, intercept = np.polyfit(means, variances, 1, w=1 / np.array(variances))
    assert slope * binning**2 == pytest.approx(gain, rel=0.015)
    dark_e = 20 * 0.030
    # The dark signal has shot noise of its own, which lies on the line: it moves along it, not above it.
    assert intercept * binning**2 == pytest.approx(gain**2 * 9.0, rel=0.06)
    assert means[0] == pytest.approx(gain * dark_e, abs=0.1)


def test_the_best_signal_to_noise_ratio_is_the_root_of_the_full_well():
    exact = replace(KNOWN, read_noise_e=0.0, dark_current_e_s=0.0)
    best = 0.0
    for share in np.arange(0.9, 1.0, 0.005):
        image = expose(even_light(light_for(share * 10_000), electrons=exact), bit_depth=14)
        if image.max() < 2**14 - 1:
            best = max(best, image.mean() / image.std())
    assert best == pytest.approx(100.0, rel=0.03)


def test_beyond_the_full_well_images_are_white_and_without_noise():
    assert set(
        np.unique(expose(even_light(light_for(20_000), electrons=replace(KNOWN, read_noise_e=0.0))))
    ) == {4095}
    below_white = expose(even_light(light_for(20_000)), system_gain_dn_per_e=0.2)
    assert below_white.mean() == pytest.approx(2000, abs=0.1)  # the well is full, the file is not
    assert below_white.std() == pytest.approx(0.2 * 3.0, rel=0.15)


def test_dark_current_grows_with_time():
    hot = replace(KNOWN, dark_current_e_s=2000.0)
    means = [
        expose(even_light(0.0, electrons=hot), replace(DAY, time_s=t), black_level_dn=100).mean() - 100
        for t in (0.1, 0.4)
    ]
    gain = (4095 - 100) / 10_000
    np.testing.assert_allclose(means, [gain * 200, gain * 800], rtol=0.005)


def test_the_catalog_comes_first_and_the_settings_fill_its_gaps():
    some = Electrons("IMX999", full_well_e=10_000.0)
    site = Emva(Emva.Config(**ELECTRONS)).photosite(even_light(1.0, electrons=some).views[0].camera)
    assert (site.full_well_e, site.quantum_efficiency, site.read_noise_e) == (10_000.0, 0.5, 2.0)


def test_what_nobody_knows_fails_the_candidate_in_a_sentence():
    some = Electrons("IMX999", full_well_e=10_000.0, read_noise_e=3.0)
    with pytest.raises(CandidateFailed) as raised:
        expose(even_light(1.0, electrons=some), dark_current_e_s=5.0)
    assert str(raised.value) == (
        "sensor.emva does not know quantum_efficiency (electrons per photon) of the image sensor IMX999: the "
        "catalog leaves it out, and so do the settings of sensor.emva"
    )


def test_colour_responses_and_mono():
    red, green, blue = expose(even_light(10.0), channel_response=(0.5, 1.0, 0.25)).mean((0, 1, 2))
    assert red / green == pytest.approx(0.5, rel=0.01)
    assert blue / green == pytest.approx(0.25, rel=0.01)
    mono = expose(even_light(10.0), channels="mono")
    assert mono.shape == (2, 120, 160, 1)
    assert mono.mean() == pytest.approx(green, rel=0.005)


def test_effects_before_the_count_change_its_noise_and_those_after_do_not():
    class Half(Dim):
        stage = "pixel"

    class HalfAfterwards(Dim):
        stage = "readout"

    capture = even_light(light_for(8000), electrons=replace(KNOWN, read_noise_e=0.0, dark_current_e_s=0.0))
    before, after = (expose(capture, effects=[placed(e, share=0.5)]) for e in (Half, HalfAfterwards))
    assert before.mean() == pytest.approx(after.mean(), rel=1e-3)
    assert before.var() / after.var() == pytest.approx(2.0, rel=0.03)


@pytest.mark.parametrize("gain_db", [0.0, 6.0])
def test_the_gain_is_that_of_a_photosite(gain_db):
    sensor, exposure = Emva(Emva.Config()), replace(DAY, gain_db=gain_db)
    gain = 4095 / 10_000 * 10 ** (gain_db / 20)
    for binning in (1.0, 3.0):
        camera = even_light(1.0, binning=binning).views[0].camera
        assert sensor.dn_per_electron(camera, exposure) == pytest.approx(gain)


def test_impossible_settings_are_refused_together():
    with pytest.raises(UserError) as raised:
        Emva(Emva.Config(black_level_dn=5000.0, channel_response=(1.0, 0.0, 1.0)))
    assert len(raised.value.faults) == 2
    assert "4095 DN at 12 bit" in str(raised.value)
