"""Conformance suite of sensors."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
import pytest

from tacos_framework.contracts.optional import optional
from tacos_framework.contracts.sensor import Samples, SensorBase
from tacos_framework.testing.component import ComponentConformance
from tacos_framework.testing.fingerprint import fingerprint
from tacos_framework.testing.forming import expose
from tacos_framework.testing.samples import sample_capture, sample_exposure, sample_rig
from tacos_framework.values import Camera, Capture, FrameBatch

DRAWS = 24
"""Draws of an image of 48 x 64 pixels, by which the noise is measured."""
NEARLY = 0.02
"""Tolerance of mean and variance beside chance [1]."""


class SensorConformance(ComponentConformance):
    """The suite for sensors."""

    kind: ClassVar[str] = "sensor"
    shares: ClassVar[tuple[float, ...]] = (0.2, 0.5)
    """Levels at which the noise is measured, over the range of the files; none where something saturates."""

    def expose(self, capture: Capture, *, seed: int = 1, time_s: float = 0.030) -> FrameBatch:
        """Frames of a capture by a new instance of the sensor, without effects."""
        return expose(self.make(), capture, seed=seed, exposure=sample_exposure(time_s=time_s))

    def camera(self, binning: float = 1.0) -> Camera:
        return replace(sample_rig().cameras[0], binning=binning)

    def expected(self, sensor: Any, share: float) -> Samples:
        """Expected samples of a flat at a share of the range, with as many channels as the sensor has."""
        light = sample_capture(frames=1).views[0].luminance_cd_m2
        samples: Samples = sensor.expect(light, camera=self.camera(), exposure=sample_exposure())
        span = sensor.white_level_dn - sensor.black_level_dn
        return np.full_like(samples, sensor.black_level_dn + share * span)

    def draw(self, sensor: Any, samples_dn: Samples, seed: int = 1, **changes: Any) -> Samples:
        """Noisy samples; `binning` and `photon_scale` may be given."""
        camera = self.camera(changes.pop("binning", 1.0))
        rng = np.random.default_rng(seed)
        drawn: Samples = sensor.draw(
            samples_dn, camera=camera, exposure=sample_exposure(), rng=rng, **changes
        )
        return drawn

    def test_its_levels_are_those_of_a_file(self) -> None:
        sensor = self.make()
        assert 0 <= sensor.black_level_dn < sensor.white_level_dn <= 65535
        assert float(sensor.white_level_dn).is_integer()

    def test_origins_of_its_figures_are_words(self) -> None:
        origins = optional(self.make(), SensorBase, "origins")
        if origins is None:
            pytest.skip("the sensor says nothing of where its figures come from")
        said = origins(self.camera())
        assert said
        assert all(isinstance(word, str) and word for pair in said.items() for word in pair)

    def test_it_gives_an_image_per_camera_and_frame(self) -> None:
        frames = self.expose(sample_capture(sample_rig("left", "right"), frames=3))
        assert len(frames.images) == 2
        for image in frames.images:
            assert image.shape[:3] == (3, 48, 64)
            assert image.shape[3] in (1, 3)

    def test_equal_generators_give_equal_draws_and_others_do_not(self) -> None:
        sensor = self.make()
        samples = self.expected(sensor, 0.5)
        first, again, other = (fingerprint(self.draw(self.make(), samples, seed)) for seed in (1, 1, 2))
        assert first == again
        assert first != other

    def test_it_leaves_what_it_is_given_as_it_was(self) -> None:
        sensor, exposure = self.make(), sample_exposure()
        light = sample_capture(frames=1).views[0].luminance_cd_m2.copy()
        before = fingerprint(light)
        samples = sensor.expect(light, camera=self.camera(), exposure=exposure)
        assert fingerprint(light) == before
        kept = fingerprint(samples)
        drawn = self.draw(sensor, samples)
        sensor.moments(samples, camera=self.camera(), exposure=exposure)
        assert fingerprint(samples) == kept
        assert not np.shares_memory(drawn, samples), "noise belongs in an array of its own"

    def test_arrays_keep_shape_and_type(self) -> None:
        sensor = self.make()
        samples = self.expected(sensor, 0.5)
        moments = sensor.moments(samples, camera=self.camera(), exposure=sample_exposure())
        for found in (samples, self.draw(sensor, samples), *moments):
            assert (np.shape(found), found.dtype) == (samples.shape, np.float32)

    @pytest.mark.parametrize("binning", [1.0, 3.0])
    @pytest.mark.parametrize("photon_scale", [1.0, 2.5])
    def test_draws_have_the_mean_and_the_variance_it_says(self, binning: float, photon_scale: float) -> None:
        sensor = self.make()
        for share in self.shares:
            samples = self.expected(sensor, share)
            changes = {"binning": binning, "photon_scale": photon_scale}
            drawn = np.stack([self.draw(sensor, samples, seed, **changes) for seed in range(DRAWS)])
            mean, variance = sensor.moments(
                samples, camera=self.camera(binning), exposure=sample_exposure(), photon_scale=photon_scale
            )
            for channel in range(samples.shape[-1]):
                seen = drawn[..., channel].astype(np.float64)
                said_mean, said = float(mean[..., channel].mean()), float(variance[..., channel].mean())
                by_chance = 5 * math.sqrt(said / seen.size)
                assert abs(seen.mean() - said_mean) <= by_chance + 1e-4 * sensor.white_level_dn, (
                    f"at {share:.0%}: {seen.mean():g} DN on average, moments say {said_mean:g}"
                )
                off = abs(seen.var() - said)
                assert off <= (NEARLY + 5 * math.sqrt(2 / seen.size)) * said + 1e-9, (
                    f"at {share:.0%}: a variance of {seen.var():g} DN^2, moments say {said:g}"
                )

    def test_photosites_that_are_averaged_have_less_noise(self) -> None:
        sensor = self.make()
        samples = self.expected(sensor, 0.5)
        one, nine = (
            sensor.moments(samples, camera=self.camera(binning), exposure=sample_exposure())[1].mean()
            for binning in (1.0, 3.0)
        )
        assert one == pytest.approx(9 * nine, rel=1e-3), "b x b photosites average to 1 / b^2 of the variance"

    def test_more_light_gives_brighter_images(self) -> None:
        capture = sample_capture(luminance_cd_m2=0.5)
        short, long = (self.expose(capture, time_s=time_s).images[0].mean() for time_s in (0.010, 0.040))
        assert short < long, f"mean {short} DN at 10 ms, {long} DN at 40 ms"

    def test_a_charge_makes_a_signal(self) -> None:
        gain = self.make().dn_per_electron(self.camera(), sample_exposure())
        assert gain is None or (math.isfinite(gain) and gain > 0), f"an electron makes {gain} DN"
        binned = self.make().dn_per_electron(self.camera(3.0), sample_exposure())
        assert binned == gain, "dn_per_electron is that of a photosite, whatever the binning"
