"""The sensor whose unpublished figures come from priors, and whose read noise falls with the gain."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tacos_framework.catalog import find_catalog
from tacos_framework.values import Camera, Electrons, Exposure, Rig
from tacos_plugins.sensors.camera import CameraSensor
from tacos_plugins.sensors.emva import NEEDED
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


@given(draw=st.integers(1, 1000), figure=st.sampled_from(sorted(PRIORS)))
def test_a_sensor_is_assumed_the_same_wherever_it_is_used(draw: int, figure: str) -> None:
    one = assumed(figure, sensor="IMX000", pixel_um=2.0, draw=draw)
    assert one == assumed(figure, sensor="IMX000", pixel_um=2.0, draw=draw)
    assert one != assumed(figure, sensor="IMX001", pixel_um=2.0, draw=draw)


def test_draws_have_the_spread_of_the_prior() -> None:
    logs = [math.log(assumed("full_well_e", sensor="X", pixel_um=2.0, draw=i)) for i in range(1, 801)]
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
        found.append(float(variance[0, 0, 0, 0]) / gain**2 - dark_e)
    assert found == pytest.approx([16.0, 16 * (0.25 + 0.0075), 4.0], rel=1e-3)


def test_drawn_noise_has_the_moments_it_states() -> None:
    model = sensor(bit_depth=12, black_level_dn=64.0)
    exposure = Exposure(gain_db=12.0)
    samples = np.full((1, 200, 200, 3), 600.0, np.float32)
    mean, variance = model.moments(samples, camera=CAMERA, exposure=exposure)
    drawn = model.draw(samples, camera=CAMERA, exposure=exposure, rng=np.random.default_rng(2))
    assert drawn.mean() == pytest.approx(
        float(mean.mean()), abs=4 * math.sqrt(float(variance.mean()) / 1.2e5)
    )
    assert drawn.var() == pytest.approx(float(variance.mean()), rel=0.02)


def test_no_camera_lacks_anything() -> None:
    assert sensor().lacks(Rig((CAMERA,))) is None
