"""The sensor whose unpublished figures come from priors, and whose read noise falls with the gain."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tacos_framework.catalog import find_catalog
from tacos_framework.testing.forming import expose
from tacos_framework.testing.samples import sample_capture
from tacos_framework.values import Camera, Electrons, Exposure, Rig
from tacos_plugins.sensors.camera import COLOURS, PEDESTAL, CameraSensor
from tacos_plugins.sensors.emva import NEEDED
from tacos_plugins.sensors.mosaic_noise import averaged_variances
from tacos_plugins.sensors.photosite_prior import PRIORS, assumed

CAMERA = Camera("camera", 64, 48, pixel_um=2.0, focal_length_mm=4.0, electrons=Electrons("IMX000"))


def sensor(**config: float) -> CameraSensor:
    return CameraSensor(CameraSensor.Config(**config))


@pytest.mark.parametrize("figure", ["full_well_e", "read_noise_e", "quantum_efficiency"])
def test_priors_are_those_of_the_shipped_catalogs(figure: str) -> None:
    """Least squares of the logarithm, or the logit, over the logarithm of the pitch."""
    parts = [
        part.values
        for name in ("image_sensors", "image_sensors_more")
        for part in find_catalog(name).rows
        if part.values.get(figure) is not None
    ]
    prior = PRIORS[figure]
    y = np.array([float(part[figure]) for part in parts])
    transformed = np.log(y / (1 - y)) if prior.is_share else np.log(y)
    pitch = np.log([float(part["pixel_um"]) for part in parts])
    slope, intercept = np.polyfit(pitch, transformed, 1)
    spread = math.sqrt(np.sum((transformed - intercept - slope * pitch) ** 2) / (len(y) - 2))
    assert prior.sensors == len(y)
    assert (prior.intercept, prior.slope, prior.spread) == pytest.approx((intercept, slope, spread), abs=2e-3)


@pytest.mark.parametrize("figure", COLOURS)
def test_colours_are_those_of_the_shipped_catalogs(figure: str) -> None:
    rows = [row for name in ("image_sensors", "image_sensors_more") for row in find_catalog(name).rows]
    logs = [math.log(row.values[figure]) for row in rows if row.values.get(figure) is not None]
    prior = PRIORS[figure]
    assert prior.sensors == len(logs)
    assert (prior.intercept, prior.spread) == pytest.approx((np.mean(logs), np.std(logs, ddof=1)), abs=2e-3)


@given(draw=st.integers(1, 1000), figure=st.sampled_from(sorted(PRIORS)))
def test_a_sensor_is_assumed_the_same_wherever_it_is_used(draw: int, figure: str) -> None:
    one = assumed(figure, sensor="IMX000", pixel_um=2.0, draw=(draw,))
    assert one == assumed(figure, sensor="IMX000", pixel_um=2.0, draw=(draw,))
    assert one != assumed(figure, sensor="IMX001", pixel_um=2.0, draw=(draw,))


def test_draws_have_the_spread_of_the_prior() -> None:
    logs = [math.log(assumed("full_well_e", sensor="X", pixel_um=2.0, draw=(i,))) for i in range(1, 801)]
    assert np.std(logs) == pytest.approx(PRIORS["full_well_e"].spread, rel=0.1)
    assert np.mean(logs) == pytest.approx(math.log(PRIORS["full_well_e"].value(2.0)), abs=0.06)


def test_stated_figures_are_kept_and_origins_tell_them_apart() -> None:
    known = replace(CAMERA, electrons=Electrons("IMX000", full_well_e=9000.0))
    model = sensor(read_noise_e=2.5)
    site = model.photosite(known)
    assert (site.full_well_e, site.read_noise_e) == (9000.0, 2.5)
    origins = model.origins(known)
    assert origins["full_well_e"] == "catalog"
    assert origins["read_noise_e"] == "settings"
    assert origins["quantum_efficiency"].startswith("assumed from 18 sensors")
    assert set(NEEDED) < set(origins)


def test_noise_in_the_file_is_that_before_and_after_the_gain() -> None:
    """b = K^2 r^2 ((1 - s) + s / G^2), so that b over G^2 falls to the share before the gain."""
    model = sensor(read_noise_e=4.0, read_noise_share_after_gain=0.75, full_well_e=10_000.0, bit_depth=12)
    dark = np.full((1, 1, 1, 3), model.black_level_dn, np.float32)
    found = []
    for gain_db in (0.0, 20.0, 80.0):
        exposure = Exposure(gain_db=gain_db)
        _, variance = model.moments(dark, camera=CAMERA, exposure=exposure)
        gain = model.gain_dn_per_e(CAMERA, exposure)
        dark_e = model.photosite(CAMERA).dark_current_e_s * exposure.time_s
        found.append(float(variance[0, 0, 0, 1]) / gain**2 - dark_e)
    assert found == pytest.approx([16.0, 16 * (0.25 + 0.0075), 4.0], rel=1e-3)


def test_drawn_noise_has_the_moments_it_states() -> None:
    model = sensor(bit_depth=12, black_level_dn=64.0)
    exposure = Exposure(gain_db=12.0)
    samples = np.full((1, 200, 200, 3), 600.0, np.float32)
    mean, variance = model.moments(samples, camera=CAMERA, exposure=exposure)
    drawn = model.draw(samples, camera=CAMERA, exposure=exposure, rng=np.random.default_rng(2))
    mean, variance = mean[0, 0, 0], variance[0, 0, 0]
    assert drawn.mean(axis=(0, 1, 2)) == pytest.approx(mean, abs=4 * math.sqrt(variance.max() / 4e4))
    assert drawn.var(axis=(0, 1, 2)) == pytest.approx(variance, rel=0.04)


def test_no_camera_lacks_anything() -> None:
    assert sensor().lacks(Rig((CAMERA,))) is None


MONO, COLOUR = (replace(CAMERA, colour=colour) for colour in ("mono", "colour"))


def test_a_part_without_filters_gives_one_channel_of_three_times_the_light() -> None:
    """Of a mosaic's photosites, half of them green, the mean gathers a third."""
    grey, raw = np.full((1, 2, 2, 3), 5.0, np.float32), sensor(white_balance=False)
    bare, filtered = (raw.expect(grey, camera=camera, exposure=Exposure()) for camera in (MONO, COLOUR))
    assert bare.shape == (1, 2, 2, 1)
    assert filtered.shape == (1, 2, 2, 3)
    np.testing.assert_allclose(bare[..., 0], 3 * (filtered @ [0.25, 0.5, 0.25]), rtol=1e-6)
    blue = np.array([[[[0.0, 0.0, 5.0]]]], np.float32)
    of_blue = sensor().expect(blue, camera=MONO, exposure=Exposure())
    assert float(of_blue[0, 0, 0, 0]) == pytest.approx(0.0722 * float(bare[0, 0, 0, 0]), rel=1e-5)


def test_colours_are_the_parts_own_and_white_balance_makes_grey_of_them() -> None:
    imx296 = replace(COLOUR, electrons=Electrons("IMX296", red_over_green=0.264, blue_over_green=0.651))
    grey = np.full((1, 1, 1, 3), 5.0, np.float32)
    raw = sensor(white_balance=False).expect(grey, camera=imx296, exposure=Exposure())[0, 0, 0]
    assert raw / raw[1] == pytest.approx([0.264, 1, 0.651], rel=1e-5)
    assert sensor().expect(grey, camera=imx296, exposure=Exposure())[0, 0, 0] == pytest.approx(raw[1])
    own = sensor(channel_response=(0.1, 0.4, 0.2), white_balance=False)
    found = own.expect(grey, camera=imx296, exposure=Exposure())[0, 0, 0]
    green = 4 / 3 / (0.264 + 2 + 0.651)
    assert found == pytest.approx(raw[1] / green * np.array([0.1, 0.4, 0.2]), rel=1e-5)
    assert sensor().origins(imx296)["red_over_green"] == "catalog"
    assert sensor().origins(COLOUR)["blue_over_green"].startswith("assumed from 7 sensors")
    assert not set(COLOURS) & set(sensor().origins(MONO))


def test_white_balance_amplifies_the_noise_of_red_by_its_gain() -> None:
    """Of equal grey, red has fewer electrons by r, each of which is 1 / r as bright: var K x / r."""
    weak = replace(COLOUR, electrons=Electrons("X", red_over_green=0.25, blue_over_green=1.0))
    model = sensor(read_noise_e=0.0, dark_current_e_s=0.0)
    samples = np.full((1, 200, 200, 3), 500.0, np.float32)
    drawn = model.draw(samples, camera=weak, exposure=Exposure(), rng=np.random.default_rng(1))
    variances = drawn.var(axis=(0, 1, 2))
    assert variances / variances[1] == pytest.approx([4.0, 1.0, 1.0], rel=0.06)


@pytest.mark.parametrize("camera", [MONO, COLOUR])
def test_blocks_of_pixels_have_the_noise_they_state(camera: Camera) -> None:
    """Of a mosaic every colour by itself; without filters a ninth of one photosite's."""
    block, model = replace(camera, binning=6, sensor_binning=2), sensor(assumptions=0)
    exposure = Exposure(gain_db=6.0)
    samples = np.full((1, 300, 300, 1 if camera is MONO else 3), 900.0, np.float32)
    drawn = model.draw(samples, camera=block, exposure=exposure, rng=np.random.default_rng(5))
    _, stated = model.moments(samples, camera=block, exposure=exposure)
    np.testing.assert_allclose(drawn.var(axis=(0, 1, 2)), stated[0, 0, 0], rtol=0.03)
    _, of_one = model.moments(samples, camera=replace(camera, binning=1.0), exposure=exposure)
    factors = [1 / 9] if camera is MONO else averaged_variances(3)
    np.testing.assert_allclose(stated[0, 0, 0] / of_one[0, 0, 0], np.array(factors) / 4, rtol=1e-5)


def test_a_second_conversion_gain_has_a_read_noise_of_its_own() -> None:
    model = sensor(read_noise_e=6.0, read_noise_share_after_gain=0.5, full_well_e=1e4)
    modes = replace(CAMERA, electrons=Electrons("IMX000", high_gain_from_db=12.0, high_gain_read_noise_e=1.5))
    noise_e = {gain_db: model.read_noise_e(modes, Exposure(gain_db=gain_db)) for gain_db in (0, 11.9, 12, 92)}
    assert noise_e[0] == pytest.approx(6.0)
    assert noise_e[11.9] == pytest.approx(model.read_noise_e(CAMERA, Exposure(gain_db=11.9)))
    assert noise_e[12] == pytest.approx(1.5)
    assert noise_e[92] == pytest.approx(1.5 * math.sqrt(0.5), rel=1e-3)


def test_a_coarse_converter_adds_its_rounding() -> None:
    """A step of 10 bits, of a full well of 10230 e-, is 10 e-: noise of 10 / sqrt 12, less by the gain."""
    coarse = replace(CAMERA, electrons=Electrons("IMX000", converter_bits=10))
    model = sensor(read_noise_e=0.0, full_well_e=10_230.0)
    assert model.read_noise_e(coarse, Exposure()) == pytest.approx(10 / math.sqrt(12))
    assert model.read_noise_e(coarse, Exposure(gain_db=20)) == pytest.approx(1 / math.sqrt(12))
    assert model.read_noise_e(CAMERA, Exposure()) == 0


def test_dark_current_doubles_with_the_temperature() -> None:
    warm = sensor(dark_current_e_s=10.0, temperature_c=45.0, dark_doubling_c=10.0)
    assert warm.photosite(CAMERA).dark_current_e_s == pytest.approx(40.0)


def test_scenes_draw_what_is_not_known_and_nothing_else() -> None:
    model = sensor(read_noise_e=2.5)
    scenes = [model.assuming((7, "test", i)) for i in range(4)]
    assert len({each.photosite(CAMERA).full_well_e for each in scenes}) == 4
    assert {each.photosite(CAMERA).read_noise_e for each in scenes} == {2.5}
    again = model.assuming((7, "test", 2))
    assert again.photosite(CAMERA) == scenes[2].photosite(CAMERA)
    assert model.photosite(CAMERA) == sensor(read_noise_e=2.5, assumptions=0).photosite(CAMERA)
    fixed = sensor(assumptions=3)
    assert fixed.assuming((7, "test", 0)).photosite(CAMERA) == fixed.photosite(CAMERA)


def test_the_pedestal_is_that_of_the_part() -> None:
    imx335 = replace(CAMERA, electrons=Electrons("IMX335", black_level_share=50 / 1023))
    files = {
        name: sensor().behind(cameras).black_level_dn
        for name, cameras in {"stated": [imx335], "unknown": [CAMERA], "both": [imx335, CAMERA]}.items()
    }
    assert files == {"stated": 200, "unknown": 256, "both": 256}  # of 4095
    assert sensor(black_level_dn=16.0).behind([imx335]).black_level_dn == 16
    assert sensor(bit_depth=8).behind([CAMERA]).black_level_dn == 16
    dark = (
        sensor()
        .behind([imx335])
        .expect(np.zeros((1, 1, 1, 3), np.float32), camera=imx335, exposure=Exposure())
    )
    assert dark.max() == dark.min() == 200
    assert sensor().origins(imx335)["black_level"] == "catalog"
    assert sensor().origins(CAMERA)["black_level"].startswith("assumed")


def test_the_usual_pedestal_is_that_of_the_shipped_catalogs() -> None:
    rows = [row.values for name in ("image_sensors", "image_sensors_more") for row in find_catalog(name).rows]
    shares = [
        row["black_level_dn"] / (2 ** row["black_level_bits"] - 1)
        for row in rows
        if row.get("black_level_dn") is not None and row.get("black_level_bits") is not None
    ]
    assert len(shares) > 20
    assert np.median(shares) == pytest.approx(PEDESTAL, rel=0.01)


def test_noise_in_the_dark_keeps_its_mean_in_the_files() -> None:
    """Without a pedestal the lower half of the noise is cut off, which brightens the dark."""
    light = sample_capture()
    views = tuple(replace(v, luminance_cd_m2=np.zeros_like(v.luminance_cd_m2)) for v in light.views)
    dark, gain = replace(light, views=views), Exposure(gain_db=30.0)
    frames = expose(sensor(dark_current_e_s=0.0), dark, exposure=gain)
    noise_dn = np.std(frames.images[0].astype(float))
    assert frames.black_level_dn == 256
    assert frames.images[0].mean() == pytest.approx(256, abs=0.05 * noise_dn)
    cut = expose(sensor(dark_current_e_s=0.0, black_level_dn=0.0), dark, exposure=gain).images[0]
    assert cut.mean() == pytest.approx(noise_dn / math.sqrt(2 * math.pi), rel=0.2)
