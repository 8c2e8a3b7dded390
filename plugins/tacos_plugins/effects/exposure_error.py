"""More or less light than the exposure settings say."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np

from tacos_framework import ImageContext, ImageGeometry, Settings, ShownBy, Stage, setting
from tacos_plugins.effects.samples import Samples
from tacos_plugins.effects.shown_by import LEVELS


class ExposureError:
    """Multiplies the light by `scale`: a shutter, a stop or a lamp that is not what the simulator believes.

    It changes the light before the noise, so that the noise is that of the brighter or darker image: points
    slide along the same photon-transfer curve.
    """

    class Config(Settings):
        scale: float = setting(1.0, help="Real over believed exposure.", gt=0, le=100)

    stage: ClassVar[Stage] = "exposure"
    rank: ClassVar[int] = 20
    neutral: ClassVar[Mapping[str, Any]] = {"scale": 1.0}
    initial_guesses: ClassVar[Sequence[Mapping[str, Any]]] = ({"scale": 1.1}, {"scale": 0.9})
    shown_by: ClassVar[Sequence[ShownBy]] = (LEVELS,)

    def __init__(self, config: Config) -> None:
        self.config = config

    def on_array(
        self, signal: Samples, *, geometry: ImageGeometry, context: ImageContext, rng: np.random.Generator
    ) -> Samples:
        if self.config.scale == 1.0:
            return signal
        return signal * signal.dtype.type(self.config.scale)
