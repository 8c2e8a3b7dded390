"""A response that bends."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from tacos_framework import ImageContext, ImageGeometry, LookAlike, Settings, ShownBy, Stage, setting
from tacos_plugins.effects import observations
from tacos_plugins.effects.pointwise import moments_behind
from tacos_plugins.effects.samples import Moments, Samples
from tacos_plugins.effects.shown_by import BRACKET


class Nonlinearity:
    """Bends the signal y, in shares of full scale above the pedestal, to ``y + a2 y^2 + a3 y^3``.

    It acts on noisy samples: the variance follows the square of the slope, unlike a tone curve drawn
    over rounded values.

    Source: EMVA 1288, release 4.0: linearity error of the response.
    """

    class Config(Settings):
        a2: float = setting(
            0.0, help="Coefficient of y^2; some -0.1 where the response saturates softly.", ge=-10, le=10
        )
        a3: float = setting(0.0, help="Coefficient of y^3.", ge=-10, le=10)

    stage: ClassVar[Stage] = "readout"
    rank: ClassVar[int] = 10
    neutral: ClassVar[Mapping[str, Any]] = {"a2": 0.0, "a3": 0.0}
    initial_guesses: ClassVar[Sequence[Mapping[str, Any]]] = ({"a2": -0.1}, {"a3": -0.1})
    look_alikes: ClassVar[Sequence[LookAlike]] = (
        LookAlike(
            "exposure-error",
            observations.one_or_two_levels,
            "bracket",
            "levels against exposure times tell a curve from a scale",
        ),
        LookAlike(
            "tone-curve",
            observations.one_or_two_levels,
            "bracket",
            "levels against exposure times tell a curve from a scale",
        ),
    )
    shown_by: ClassVar[Sequence[ShownBy]] = (BRACKET,)

    def __init__(self, config: Config) -> None:
        self.config = config

    def on_array(
        self, signal: Samples, *, geometry: ImageGeometry, context: ImageContext, rng: np.random.Generator
    ) -> Samples:
        if self.config.a2 == 0 and self.config.a3 == 0:
            return signal
        return self._bent(signal, context)

    def moments(
        self, mean_dn: Samples, variance_dn2: Samples, *, geometry: ImageGeometry, context: ImageContext
    ) -> Moments:
        """Moments of Gaussian noise on the bent response."""
        if self.config.a2 == 0 and self.config.a3 == 0:
            return mean_dn, variance_dn2
        return moments_behind(lambda x: self._bent(x, context), mean_dn, variance_dn2)

    def _bent(self, signal: NDArray[Any], context: ImageContext) -> NDArray[Any]:
        full_scale_dn = context.white_level_dn - context.black_level_dn
        y = (signal - context.black_level_dn) / full_scale_dn
        return signal + full_scale_dn * y**2 * (self.config.a2 + self.config.a3 * y)
