"""Light that falls off towards the corners."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, ClassVar

import numpy as np

from tacos_framework import (
    Captures,
    Estimate,
    ImageContext,
    ImageGeometry,
    LookAlike,
    Settings,
    ShownBy,
    Stage,
    setting,
)
from tacos_plugins.effects import closed_forms, observations
from tacos_plugins.effects.radial import brightens, even_polynomial
from tacos_plugins.effects.samples import Samples
from tacos_plugins.effects.shown_by import FALL_OFF


class Vignetting:
    """Multiplies the light by ``1 + k1 r^2 + k2 r^4 + k3 r^6``, with r over half the sensor's diagonal.

    The fall-off is centred on the principal point. It dims light, before the noise: the noise in
    the corners is that of their lower signal.

    Source: Goldman 2010, "Vignette and exposure calibration and compensation", IEEE Trans. PAMI 32(12): the
    even polynomial of third order.
    """

    class Config(Settings):
        k1: float = setting(0.0, help="Coefficient of r^2; about -0.4 for a small wide lens.", ge=-10, le=10)
        k2: float = setting(0.0, help="Coefficient of r^4.", ge=-10, le=10)
        k3: float = setting(0.0, help="Coefficient of r^6.", ge=-10, le=10)

    stage: ClassVar[Stage] = "optics"
    rank: ClassVar[int] = 60
    neutral: ClassVar[Mapping[str, Any]] = {"k1": 0.0, "k2": 0.0, "k3": 0.0}
    initial_guesses: ClassVar[Sequence[Mapping[str, Any]]] = ({"k1": -0.2}, {"k2": -0.2}, {"k3": -0.2})
    look_alikes: ClassVar[Sequence[LookAlike]] = (
        LookAlike(
            "illumination-gradient",
            observations.one_flat_without_stack,
            "flat",
            "rotated by 90 degrees it tells vignetting from uneven light",
        ),
        LookAlike(
            "lens-shading-correction",
            observations.one_flat_without_stack,
            "flat",
            "a stack of frames: noise over the field tells light lost from values scaled",
        ),
    )
    shown_by: ClassVar[Sequence[ShownBy]] = (FALL_OFF,)

    def __init__(self, config: Config) -> None:
        self.config = config

    @property
    def plausible(self) -> bool:
        """True if light falls off, or at least does not rise: no lens brightens its corners."""
        return not brightens(self.config.k1, self.config.k2, self.config.k3)

    @classmethod
    def estimate_from(cls, captures: Captures) -> Iterator[Estimate]:
        """The even polynomial that fits walls best beside a plane of light."""
        if found := closed_forms.shading(captures):
            yield Estimate("k1", *found.k1, negligible=0.004)
            yield Estimate("k2", *found.k2, negligible=0.004)

    def on_array(
        self, signal: Samples, *, geometry: ImageGeometry, context: ImageContext, rng: np.random.Generator
    ) -> Samples:
        k1, k2, k3 = self.config.k1, self.config.k2, self.config.k3
        if not any((k1, k2, k3)):
            return signal
        relative_illumination = even_polynomial(geometry.radius, k1, k2, k3)
        return signal * relative_illumination.astype(signal.dtype)[..., None]
