"""Photosites that respond more or less than their neighbours."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from tacos_framework import (
    Captures,
    Estimate,
    ImageContext,
    ImageGeometry,
    LookAlike,
    ShownBy,
    Stage,
    setting,
)
from tacos_plugins.effects import closed_forms, observations
from tacos_plugins.effects.fixed_pattern import PatternSettings, pixel_pattern
from tacos_plugins.effects.samples import Moments, Samples
from tacos_plugins.effects.shown_by import FLAT, REPEATED_FLAT


class Prnu:
    """Photo-response non-uniformity: multiplies the light's signal by ``1 + sigma p``.

    The pattern p has mean 0 and variance 1 and belongs to the sensor: it repeats in every frame, and adds
    spatial variance in proportion to the squared signal, no temporal variance. It acts before the noise.

    Source: EMVA 1288, release 4.0: PRNU1288.
    """

    class Config(PatternSettings):
        sigma: float = setting(
            0.0,
            help="Spread of the photosites' response, over its mean; 0.003 to 0.015 is usual.",
            averaging="photosites",
            ge=0,
            le=1,
        )

    stage: ClassVar[Stage] = "pixel"
    rank: ClassVar[int] = 10
    neutral: ClassVar[Mapping[str, Any]] = {"sigma": 0.0}
    initial_guesses: ClassVar[Sequence[Mapping[str, Any]]] = ({"sigma": 0.01},)
    look_alikes: ClassVar[Sequence[LookAlike]] = (
        LookAlike(
            "conversion-gain-error",
            observations.no_repeats,
            "flat",
            "two or more frames of one setting tell fixed patterns from noise",
        ),
    )
    shown_by: ClassVar[Sequence[ShownBy]] = (FLAT, REPEATED_FLAT)

    def __init__(self, config: Config) -> None:
        self.config = config

    @classmethod
    def estimate_from(cls, captures: Captures) -> Iterator[Estimate]:
        """The same covariance of walls, over their squared signal."""
        walls = closed_forms.whole_walls(captures, frames=2)
        if found := closed_forms.pattern_variance(walls, relative=True):
            yield Estimate("sigma", *closed_forms.root(found), negligible=0.001)

    def on_array(
        self, signal: Samples, *, geometry: ImageGeometry, context: ImageContext, rng: np.random.Generator
    ) -> Samples:
        if self.config.sigma == 0:
            return signal
        return _scaled(signal, self._response(geometry, signal.shape[-1]), context.black_level_dn)

    def moments(
        self, mean_dn: Samples, variance_dn2: Samples, *, geometry: ImageGeometry, context: ImageContext
    ) -> Moments:
        """Means with the pattern; variance that is already there goes with its square."""
        if self.config.sigma == 0:
            return mean_dn, variance_dn2
        response = self._response(geometry, mean_dn.shape[-1])
        return _scaled(mean_dn, response, context.black_level_dn), variance_dn2 * response**2

    def _response(self, geometry: ImageGeometry, channels: int) -> NDArray[np.float32]:
        return 1 + np.float32(self.config.sigma) * pixel_pattern("prnu", self.config, geometry, channels)


def _scaled(
    signal: NDArray[np.floating], factor: NDArray[np.float32], black_level_dn: float
) -> NDArray[np.floating]:
    return (signal - black_level_dn) * factor.astype(signal.dtype, copy=False) + black_level_dn
