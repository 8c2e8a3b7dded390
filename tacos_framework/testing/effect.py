"""What every effect must do."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, get_args

import numpy as np

from tacos_framework.contracts import Stage
from tacos_framework.testing.component import ComponentConformance
from tacos_framework.testing.fingerprint import fingerprint
from tacos_framework.testing.samples import (
    sample_capture,
    sample_exposure,
    sample_frames,
    sample_rig,
    sample_signal,
)


class EffectConformance(ComponentConformance):
    """The suite for effects; ``config`` must be one at which the effect can be seen."""

    kind: ClassVar[str] = "effect"

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

    def test_its_stage_is_one_of_image_formation(self) -> None:
        assert self.component.stage in get_args(Stage)

    def test_its_neutral_values_are_settings(self) -> None:
        assert self.component.neutral, "an effect names the values at which it is off"
        unknown = set(self.component.neutral) - set(self.component.Config.model_fields)
        assert not unknown, f"neutral names no settings: {', '.join(sorted(unknown))}"

    def test_it_is_exactly_off_at_its_neutral_values(self) -> None:
        image = self.sample()
        off = self.apply(image, {**self.config, **self.component.neutral})
        assert fingerprint(off) == fingerprint(image)

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
        assert fingerprint(image) == before
