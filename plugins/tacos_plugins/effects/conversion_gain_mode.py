"""A second conversion gain that the simulator knows nothing of."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, ClassVar

import numpy as np

from tacos_framework import Captures, ImageContext, ImageGeometry, Settings, ShownBy, Stage, setting
from tacos_plugins.effects.samples import Samples
from tacos_plugins.effects.shown_by import TWO_GAINS


class ConversionGainMode:
    """Changes the noise without light from some gain on, where a photosite gives more volts per electron.

    Read noise of the circuits behind it is then fewer electrons. At a given gain of the camera, digital
    numbers per electron are as before, and with them the photon noise.

    Source: EMVA 1288, release 4.0: var = K^2 var_d + K (mean - mean_dark), of which the mode changes var_d.
    """

    class Config(Settings):
        from_db: float = setting(0.0, help="Gain from which on the mode is used.", unit="dB", ge=-200, le=200)
        noise_scale: float = setting(
            1.0, help="Actual over believed noise without light in that mode.", ge=0, le=1e3
        )

    stage: ClassVar[Stage] = "pixel"
    rank: ClassVar[int] = 41
    neutral: ClassVar[Mapping[str, Any]] = {"noise_scale": 1.0}
    initial_guesses: ClassVar[Sequence[Mapping[str, Any]]] = ()
    shown_by: ClassVar[Sequence[ShownBy]] = (TWO_GAINS,)

    def __init__(self, config: Config) -> None:
        self.config = config

    @classmethod
    def guesses_from(cls, captures: Captures) -> Iterator[Mapping[str, Any]]:
        """Less noise from each of the gains of the captures on, but the lowest."""
        lowest, *others = sorted({capture.context.gain_db for capture in captures})
        for gain_db in others:
            yield {"from_db": max(math.floor(gain_db), math.floor(lowest) + 1), "noise_scale": 0.7}

    def dark_scale(self, context: ImageContext) -> float:
        """Factor on the variance of the noise without light [1]."""
        return self.config.noise_scale**2 if context.gain_db >= self.config.from_db else 1.0

    def on_array(
        self, signal: Samples, *, geometry: ImageGeometry, context: ImageContext, rng: np.random.Generator
    ) -> Samples:
        """The samples themselves: only the noise changes."""
        return signal
