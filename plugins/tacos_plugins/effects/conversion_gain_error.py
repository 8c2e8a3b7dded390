"""A conversion gain other than the simulator believes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np

from tacos_framework import ImageContext, ImageGeometry, Settings, ShownBy, Stage, setting
from tacos_plugins.effects.samples import Samples
from tacos_plugins.effects.shown_by import FLAT


class ConversionGainError:
    """Multiplies the slope of the photon-transfer curve and leaves the signal as it is.

    A pixel gives K digital numbers per electron, and the variance of its photon noise is K times the
    signal: with another K the same digital number stands for fewer or more electrons. What is left unchanged:
    the mean, since the exposure that reaches it is the scenario's; and the noise without signal, which is
    measured in digital numbers in the dark. The sensor draws the noise: the effect changes no sample itself,
    and the sensor is told the product of all `photon_scale`.

    Source: EMVA 1288, release 4.0: the photon-transfer method, var = K^2 var_d + K (mean - mean_dark).
    """

    class Config(Settings):
        scale: float = setting(
            1.0,
            help="Actual over believed conversion gain: factor on the slope of variance over mean.",
            gt=0,
            le=1e3,
        )

    stage: ClassVar[Stage] = "pixel"
    rank: ClassVar[int] = 40
    neutral: ClassVar[Mapping[str, Any]] = {"scale": 1.0}
    initial_guesses: ClassVar[Sequence[Mapping[str, Any]]] = ({"scale": 1.3}, {"scale": 0.75})
    shown_by: ClassVar[Sequence[ShownBy]] = (FLAT,)

    def __init__(self, config: Config) -> None:
        self.config = config

    @property
    def photon_scale(self) -> float:
        """Factor on the variance of the photon noise [1]."""
        return self.config.scale

    def on_array(
        self, signal: Samples, *, geometry: ImageGeometry, context: ImageContext, rng: np.random.Generator
    ) -> Samples:
        """The samples themselves: only the noise changes."""
        return signal
