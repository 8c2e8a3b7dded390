"""What every effect must do."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, ClassVar, get_args

import numpy as np
import pytest
from annotated_types import Ge, Gt, Le, Lt
from numpy.typing import NDArray

from tacos_framework.camera.motion import image_velocity
from tacos_framework.contracts import STAGES, Stage
from tacos_framework.testing.component import ComponentConformance
from tacos_framework.testing.fingerprint import fingerprint
from tacos_framework.testing.samples import (
    sample_capture,
    sample_exposure,
    sample_frames,
    sample_rig,
    sample_signal,
)
from tacos_framework.values import Capture, ImageContext, ImageGeometry, Signal, View

NEARLY = 1e-3
"""How far a nearly neutral parameter lies on the way from neutral to the suite's ``config`` [1]."""


class EffectConformance(ComponentConformance):
    """The suite for effects; ``config`` must be one at which the effect can be seen."""

    kind: ClassVar[str] = "effect"
    begins_at_once: ClassVar[bool] = False
    """True where the least departure from neutral is seen, as when rounding begins; skips the test of it."""

    def sample(self) -> Any:
        """An image of the type its stage works on; override to give one that shows the effect."""
        stage = self.component.stage
        if stage in ("scene", "optics", "exposure"):
            return sample_capture()
        return sample_signal() if stage in ("pixel", "readout") else sample_frames()

    def apply(self, image: Any, config: Mapping[str, Any], *, seed: int = 1) -> Any:
        """The image with the effect at a configuration."""
        effect = self.component(self.component.Config(**config))
        return effect.apply(
            image, rig=sample_rig(), exposure=sample_exposure(), rng=np.random.default_rng(seed)
        )

    def on_array(self, image: Any, config: Mapping[str, Any], *, seed: int = 1) -> tuple[Any, Any]:
        """The plain array of the first view, before and after the effect."""
        effect = self.component(self.component.Config(**config))
        view, samples, context = _plain(image)
        geometry = ImageGeometry.of_camera(view.camera)
        rng = np.random.default_rng(seed)
        return samples, effect.on_array(samples, geometry=geometry, context=context, rng=rng)

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
        assert self.component.stage in get_args(Stage)

    def test_its_stage_fits_the_image_it_takes(self) -> None:
        hints = self.component.apply.__annotations__
        taken = getattr(hints.get("image"), "__name__", hints.get("image"))
        after_light = STAGES.index(self.component.stage) - STAGES.index("pixel")
        expected = "Capture" if after_light < 0 else "Signal" if after_light < 2 else "FrameBatch"
        assert taken == expected, f"stage {self.component.stage} works on a {expected}, not on a {taken}"

    def test_its_parameters_are_bounded_on_both_sides(self) -> None:
        fields = self.component.Config.model_fields
        unbounded = []
        for name, off in self.component.neutral.items():
            kinds = {type(bound) for bound in fields[name].metadata}
            number = isinstance(off, int | float) and not isinstance(off, bool)
            if number and not (kinds & {Ge, Gt} and kinds & {Le, Lt}):
                unbounded.append(name)
        assert not unbounded, f"a fit needs a lower and an upper bound of {', '.join(unbounded)}"

    def test_its_neutral_values_are_settings(self) -> None:
        assert self.component.neutral, "an effect names the values at which it is off"
        unknown = set(self.component.neutral) - set(self.component.Config.model_fields)
        assert not unknown, f"neutral names no settings: {', '.join(sorted(unknown))}"

    def test_it_is_exactly_off_at_its_neutral_values(self) -> None:
        image = self.sample()
        before = fingerprint(image)
        off = self.apply(image, {**self.config, **self.component.neutral})
        assert fingerprint(off) == before
        assert off is image, "an effect that is off hands on the very object it was given"

    def test_arrays_pass_unchanged_at_its_neutral_values(self) -> None:
        samples, off = self.on_array(self.sample(), {**self.config, **self.component.neutral})
        assert off is samples, "an effect that is off hands on the very array it was given"

    def test_it_vanishes_as_its_parameters_near_the_neutral_values(self) -> None:
        config = self.nearly_neutral()
        if self.begins_at_once or not config:
            pytest.skip("the effect does not set in gradually")
        image = self.sample()
        before, full = self.on_array(image, self.config)
        _, near = self.on_array(image, config)
        change, little = (float(np.abs(after - before).mean()) for after in (full, near))
        assert little <= 0.1 * change, (
            f"{config} changes samples by {little:g}, the full effect by {change:g}"
        )

    def test_it_changes_the_image_at_other_values(self) -> None:
        image = self.sample()
        assert fingerprint(self.apply(image, self.config)) != fingerprint(image)

    def test_it_keeps_the_type_of_the_image(self) -> None:
        image = self.sample()
        assert type(self.apply(image, self.config)) is type(image)

    def test_equal_generators_give_equal_images(self) -> None:
        image = self.sample()
        first, second = (self.apply(image, self.config, seed=3) for _ in range(2))
        assert fingerprint(first) == fingerprint(second)

    def test_it_leaves_its_input_as_it_was(self) -> None:
        image = self.sample()
        before = fingerprint(image)
        self.apply(image, self.config)
        self.on_array(image, self.config)
        assert fingerprint(image) == before

    def test_on_arrays_it_does_what_it_does_to_an_image(self) -> None:
        image = _first_view_only(self.sample())
        _, expected = self.on_array(image, self.config)
        _, found, _ = _plain(self.apply(image, self.config))
        if not isinstance(image, Capture | Signal):
            expected = np.clip(np.rint(expected), 0, image.white_level_dn)
        np.testing.assert_array_equal(found, expected)

    @pytest.mark.parametrize("dtype", [np.float32, np.float64])
    def test_arrays_keep_shape_and_type(self, dtype: type[np.floating[Any]]) -> None:
        effect = self.make()
        view, samples, context = _plain(self.sample())
        given = samples.astype(dtype)
        geometry = ImageGeometry.of_camera(view.camera)
        result = effect.on_array(given, geometry=geometry, context=context, rng=np.random.default_rng(1))
        assert (result.shape, result.dtype) == (given.shape, given.dtype)


def _plain(image: Any) -> tuple[View, NDArray[np.float32], ImageContext]:
    """The first view of an image, its samples, and all that is known of it."""
    exposure = sample_exposure()
    if isinstance(image, Capture):
        view = image.views[0]
        context = replace(
            ImageContext.of_light(view, exposure), velocity_px_s=image_velocity(view, image.episode)
        )
        return view, view.luminance_cd_m2, context
    is_signal = isinstance(image, Signal)
    view = image.view if is_signal else image.capture.views[0]
    samples = image.samples_dn if is_signal else image.images[0].astype(np.float32)
    context = ImageContext(
        exposure_s=exposure.time_s,
        gain_db=exposure.gain_db,
        f_number=exposure.f_number,
        black_level_dn=image.black_level_dn,
        white_level_dn=image.white_level_dn,
        depth_m=view.depth_m,
    )
    return view, samples, context


def _first_view_only(image: Any) -> Any:
    if isinstance(image, Capture):
        return replace(image, views=image.views[:1])
    if isinstance(image, Signal):
        return image
    capture = _first_view_only(image.capture)
    return replace(image, capture=capture, images=image.images[:1])
