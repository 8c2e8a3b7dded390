"""Faults of a camera: effects, each acting at one point of image formation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, dataclass_transform

import numpy as np

from tacos_validation.blind.generators.camera import IdealShot, Image


@dataclass_transform(frozen_default=True)
@dataclass(frozen=True)
class InjectedEffect:
    """One effect; neutral but where a subclass overrides. Fields are the catalogue's parameters.

    A subclass says both in its head, ``class ReadNoise(InjectedEffect, name="read-noise", place=3)``, and is
    a frozen data class.
    """

    name: ClassVar[str]
    place: ClassVar[int]  # among effects that act at the same point

    def __init_subclass__(cls, *, name: str = "", place: int = 0) -> None:
        super().__init_subclass__()
        cls.name, cls.place = name, place
        dataclass(frozen=True)(cls)

    @property
    def photon_factor(self) -> float:
        """Factor on the digital numbers per electron, at the same mean."""
        return 1.0

    def dark_factor(self, shot: IdealShot) -> float:
        """Factor on the noise without light."""
        return 1.0

    def rays(self, x: Image, y: Image, channel: int, shot: IdealShot, row: Image) -> tuple[Image, Image]:
        """Origin, in the ideal image, of the light that arrives at (x, y); `row` is read there."""
        return x, y

    def light(self, light: Image, shot: IdealShot, pad: int) -> Image:
        """Change light before it is counted, (H + 2 pad, W + 2 pad, C) [DN above the pedestal]."""
        return light

    def frame_light(self, light: Image, shot: IdealShot, rng: np.random.Generator) -> Image:
        """Change the light of a single frame, (H, W, C)."""
        return light

    def charge(self, mean: Image, shot: IdealShot, sensor: np.random.Generator) -> Image:
        """Change the expected charge, (H, W, C) [DN above the pedestal]; `sensor` is alike in all frames."""
        return mean

    def samples(self, samples: Image, shot: IdealShot, rng: np.random.Generator) -> Image:
        """Change noisy samples before they become codes, (H, W, C) [DN, with pedestal]."""
        return samples

    def codes(self, codes: Image, shot: IdealShot, sensor: np.random.Generator) -> Image:
        """Change codes, (H, W, C) whole numbers [DN, with pedestal]."""
        return codes

    @property
    def parameters(self) -> dict[str, Any]:
        return dict(vars(self))
