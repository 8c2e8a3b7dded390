"""Conformance suite of effects."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
import pytest
from annotated_types import Ge, Gt, Le, Lt
from numpy.typing import NDArray

from tacos_framework.camera.motion import image_velocity
from tacos_framework.camera.resampling import resample
from tacos_framework.contracts import FILE_STAGES, LIGHT_STAGES, STAGES, EffectBase, moves_pixels, optional
from tacos_framework.formation import in_image_units
from tacos_framework.settings import physical_settings
from tacos_framework.testing.component import ComponentConformance
from tacos_framework.testing.fingerprint import fingerprint
from tacos_framework.testing.forming import expose, placed, with_effect
from tacos_framework.testing.linear_sensor import LinearSensor
from tacos_framework.testing.samples import sample_capture, sample_expected_dn, sample_exposure, sample_frames
from tacos_framework.values import Capture, FrameBatch, ImageContext, ImageGeometry

NEARLY = 1e-3
"""Place of a nearly neutral parameter on the way from neutral to the suite's ``config`` [1]."""


class EffectConformance(ComponentConformance):
    """The suite for effects; ``config`` must be one at which the effect can be seen."""

    kind: ClassVar[str] = "effect"
    begins_at_once: ClassVar[bool] = False
    """True where the least departure from neutral is seen, as when rounding begins; skips the test of it."""

    def sample(self) -> NDArray[np.float32]:
        """(N, H, W, C) of what its stage works on; override for an image that shows the effect."""
        if self.component.stage in LIGHT_STAGES:
            return sample_capture().views[0].luminance_cd_m2
        if self.component.stage in FILE_STAGES:
            return sample_frames().images[0].astype(np.float32)
        return sample_expected_dn()

    def context(self) -> ImageContext:
        capture, exposure = sample_capture(), sample_exposure()
        view, in_sensor = capture.views[0], self.component.stage in ("pixel", "readout")
        return ImageContext(
            exposure_s=exposure.time_s,
            gain_db=exposure.gain_db,
            f_number=exposure.f_number,
            black_level_dn=16.0 if in_sensor else 0.0,
            depth_m=view.depth_m,
            velocity_px_s=image_velocity(view, capture.episode),
            dn_per_electron=0.1,
        )

    def geometry(self) -> ImageGeometry:
        return ImageGeometry.of_camera(sample_capture().views[0].camera)

    def on_array(self, samples: NDArray[Any], config: Mapping[str, Any], *, seed: int = 1) -> NDArray[Any]:
        """Samples with the effect at a configuration, as the framework does it."""
        geometry, context = self.geometry(), self.context()
        settings = in_image_units(self.component.Config(**config), "the effect", geometry, context)
        effect = self.component(settings)
        if moves_pixels(self.component):
            places = effect.source(geometry=geometry, context=context, frames=len(samples))
            return samples if places is None else resample(samples, *places)
        changed: NDArray[Any] = effect.on_array(
            samples, geometry=geometry, context=context, rng=np.random.default_rng(seed)
        )
        return changed

    def image(self) -> Capture | FrameBatch:
        """A capture, or frames for an effect on files."""
        return sample_frames() if self.component.stage in FILE_STAGES else sample_capture()

    def exactly_off(self) -> dict[str, Any]:
        """The configuration at the neutral values, physical ones taken out."""
        neutral = self.component.neutral
        instead = physical_settings(self.component.Config)
        kept = {name: v for name, v in self.config.items() if instead.get(name) not in neutral}
        return {**kept, **neutral}

    def nearly_neutral(self) -> dict[str, Any]:
        """The configuration with every number close to its neutral value; empty where none can be."""
        near = {}
        for name, off in self.component.neutral.items():
            given = self.config.get(name, off)
            if isinstance(off, float) and isinstance(given, int | float) and given != off:
                near[name] = off + NEARLY * (given - off)
        others = {name: off for name, off in self.component.neutral.items() if name not in near}
        return {**self.config, **others, **near} if near else {}

    def test_its_stage_is_one_of_image_formation(self) -> None:
        assert self.component.stage in STAGES, f"stage is one of {', '.join(STAGES)}"

    def test_it_is_written_on_arrays_or_says_where_pixels_come_from(self) -> None:
        offered = [name for name in ("on_array", "source") if callable(getattr(self.component, name, None))]
        assert len(offered) == 1, f"an effect has either on_array or source, not {offered or 'none of them'}"

    def test_it_names_settings_alone(self) -> None:
        """Bounds, neutral values and initial guesses are of settings that exist."""
        fields = self.component.Config.model_fields
        assert self.component.neutral, "an effect names the values at which it is off"
        unknown = set(self.component.neutral) - set(fields)
        assert not unknown, f"neutral names no settings: {', '.join(sorted(unknown))}"
        by_capture = set(optional(self.component, EffectBase, "by_capture"))
        assert by_capture <= set(self.component.neutral), "by_capture names settings that have a neutral one"
        for guess in optional(self.component, EffectBase, "initial_guesses") or ():
            self.component.Config(**guess)

    def test_its_physical_settings_stand_for_others(self) -> None:
        fields = self.component.Config.model_fields
        for name, image_name in physical_settings(self.component.Config).items():
            assert image_name in fields, f"{name} stands for {image_name}, which is no setting"
            assert fields[name].default is None, f"{name} is given unless it is left out"

    def test_its_parameters_are_bounded_on_both_sides(self) -> None:
        fields = self.component.Config.model_fields
        unbounded = []
        for name, off in self.component.neutral.items():
            kinds = {type(bound) for bound in fields[name].metadata}
            number = isinstance(off, int | float) and not isinstance(off, bool)
            if number and not (kinds & {Ge, Gt} and kinds & {Le, Lt}):
                unbounded.append(name)
        assert not unbounded, f"a fit needs a lower and an upper bound of {', '.join(unbounded)}"

    def test_it_is_exactly_off_at_its_neutral_values(self) -> None:
        samples = self.sample()
        before = fingerprint(samples)
        off = self.on_array(samples, self.exactly_off())
        assert fingerprint(off) == before
        assert off is samples, "an effect that is off hands on the very array it was given"

    def test_it_vanishes_as_its_parameters_near_the_neutral_values(self) -> None:
        config = self.nearly_neutral()
        if self.begins_at_once or not config:
            pytest.skip("the effect does not set in gradually")
        samples = self.sample()
        full, near = self.on_array(samples, self.config), self.on_array(samples, config)
        change, little = (float(np.abs(after - samples).mean()) for after in (full, near))
        assert little <= 0.1 * change, (
            f"{config} changes samples by {little:g}, the full effect by {change:g}"
        )

    def test_it_changes_the_image_at_other_values(self) -> None:
        samples, effect = self.sample(), self.make()
        changed = fingerprint(self.on_array(samples, self.config)) != fingerprint(samples)
        assert (
            changed
            or optional(effect, EffectBase, "photon_scale") != 1.0
            or optional(effect, EffectBase, "dark_scale")
        )

    def test_equal_generators_give_equal_images(self) -> None:
        samples = self.sample()
        first, second = (self.on_array(samples, self.config, seed=3) for _ in range(2))
        assert fingerprint(first) == fingerprint(second)

    def test_it_leaves_its_input_as_it_was(self) -> None:
        samples = self.sample().copy()
        before = fingerprint(samples)
        self.on_array(samples, self.config)
        assert fingerprint(samples) == before

    @pytest.mark.parametrize("dtype", [np.float32, np.float64])
    def test_arrays_keep_shape_and_type(self, dtype: type[np.floating[Any]]) -> None:
        given = self.sample().astype(dtype)
        result = self.on_array(given, self.config)
        assert (result.shape, result.dtype) == (given.shape, given.dtype)

    def test_it_acts_in_image_formation(self) -> None:
        """The framework brings it to captures and frames, one frame at a time."""
        image: Any = self.image()
        changed = with_effect(image, placed(self.component, **self.config))
        assert type(changed) is type(image)
        if getattr(changed, "pending", ()):
            image, changed = (expose(LinearSensor(), each, seed=2) for each in (image, changed))
        assert fingerprint(changed) != fingerprint(image)

    def test_off_it_hands_images_on_without_a_copy(self) -> None:
        image: Any = self.image()
        effect = placed(self.component, **self.exactly_off())
        off = with_effect(image, effect)
        assert off is image or (self.component.stage in ("pixel", "readout") and off.pending == (effect,))
