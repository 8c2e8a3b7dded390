"""Faults of sensors: in noise, in levels, in what they are given."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tacos_framework.testing import SensorConformance
from tacos_plugins.sensors.affine_noise import AffineNoise
from tests.testing.applied_suite import bound, faults_are_found


class UnseededSensor(AffineNoise):
    def draw(self, samples_dn, *, rng, **supplied):
        return super().draw(samples_dn, rng=np.random.default_rng(), **supplied)


class DarkeningSensor(AffineNoise):
    def expect(self, light_cd_m2, *, camera, exposure):
        exposure = replace(exposure, time_s=1e-3 / exposure.time_s)
        return super().expect(light_cd_m2, camera=camera, exposure=exposure)


class UnderstatingSensor(AffineNoise):
    """Draws more noise than it says."""

    def moments(self, samples_dn, **supplied):
        mean, variance = super().moments(samples_dn, **supplied)
        return mean, variance * np.float32(0.9)


class BiasedSensor(AffineNoise):
    def draw(self, samples_dn, **supplied):
        return super().draw(samples_dn, **supplied) + np.float32(0.5)


class DeafSensor(AffineNoise):
    """Knows nothing of the scale of the photon noise."""

    def draw(self, samples_dn, *, photon_scale=1.0, **supplied):
        return super().draw(samples_dn, **supplied)


class UnbinnedSensor(AffineNoise):
    """Forgets that pixels are averages of photosites."""

    def noise_levels(self, camera, gain_db):
        return super().noise_levels(replace(camera, binning=1.0), gain_db)


class BinnedGainSensor(AffineNoise):
    def dn_per_electron(self, camera, exposure):
        return super().dn_per_electron(camera, exposure) / camera.binning**2


class WritingSensor(AffineNoise):
    def expect(self, light_cd_m2, **supplied):
        light_cd_m2 *= np.float32(0.5)
        return super().expect(light_cd_m2, **supplied)


class NoisyInPlaceSensor(AffineNoise):
    def draw(self, samples_dn, **supplied):
        samples_dn[...] = super().draw(samples_dn, **supplied)
        return samples_dn


class BottomlessSensor(AffineNoise):
    black_level_dn = -1.0


FAULTS = [
    (UnseededSensor, "test_equal_generators_give_equal_draws_and_others_do_not"),
    (DarkeningSensor, "test_more_light_gives_brighter_images"),
    (UnbinnedSensor, "test_photosites_that_are_averaged_have_less_noise"),
    (BinnedGainSensor, "test_a_charge_makes_a_signal"),
    (WritingSensor, "test_it_leaves_what_it_is_given_as_it_was"),
    (NoisyInPlaceSensor, "test_it_leaves_what_it_is_given_as_it_was"),
    (BottomlessSensor, "test_its_levels_are_those_of_a_file"),
]


test_a_fault_is_found = faults_are_found([(SensorConformance, *fault) for fault in FAULTS])


@pytest.mark.parametrize(
    ("component", "said"),
    [(UnderstatingSensor, "a variance of"), (BiasedSensor, "on average"), (DeafSensor, "a variance of")],
)
def test_a_sensor_whose_draws_are_not_what_it_says_is_found(component, said):
    suite = bound(SensorConformance, component)
    with pytest.raises(AssertionError, match=said):
        suite.test_draws_have_the_mean_and_the_variance_it_says(binning=3.0, photon_scale=2.5)
