"""Red and blue lifted or lowered against green."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from tacos_framework import ContextMissing, ImageContext, ImageGeometry, Settings, ShownBy, Stage, setting
from tacos_plugins.effects.mosaic import mosaic_channels
from tacos_plugins.effects.samples import Moments, Samples
from tacos_plugins.effects.shown_by import COLOURS


class WhiteBalance:
    """Multiplies red and blue, above the pedestal, by gains; green stays.

    Works on full-colour images, and on mosaics whose colour filters are known.
    """

    class Config(Settings):
        red: float = setting(1.0, help="Gain of red.", gt=0, le=100)
        blue: float = setting(1.0, help="Gain of blue.", gt=0, le=100)

    stage: ClassVar[Stage] = "isp"
    rank: ClassVar[int] = 20
    of_colours: ClassVar[bool] = True
    neutral: ClassVar[Mapping[str, Any]] = {"red": 1.0, "blue": 1.0}
    initial_guesses: ClassVar[Sequence[Mapping[str, Any]]] = ({"red": 1.1}, {"blue": 1.1})
    shown_by: ClassVar[Sequence[ShownBy]] = (COLOURS,)

    def __init__(self, config: Config) -> None:
        self.config = config

    def _gain(self, shape: tuple[int, ...], context: ImageContext) -> NDArray[np.float64]:
        """Gains that broadcast to samples of a shape [1]."""
        gains = np.array([self.config.red, 1.0, self.config.blue])
        if shape[-1] == 3:
            return gains
        if context.cfa is None:
            raise ContextMissing(
                "effect.white-balance needs images in colour, or the colour filters of a mosaic"
            )
        return gains[mosaic_channels(context.cfa, shape[1], shape[2])][..., None]

    def on_array(
        self, signal: Samples, *, geometry: ImageGeometry, context: ImageContext, rng: np.random.Generator
    ) -> Samples:
        if self.config.red == 1 and self.config.blue == 1:
            return signal
        gain = self._gain(signal.shape, context).astype(signal.dtype)
        return (signal - context.black_level_dn) * gain + context.black_level_dn

    def moments(
        self, mean_dn: Samples, variance_dn2: Samples, *, geometry: ImageGeometry, context: ImageContext
    ) -> Moments:
        """Means with the gains, variances with their squares."""
        if self.config.red == 1 and self.config.blue == 1:
            return mean_dn, variance_dn2
        gain = self._gain(np.broadcast_shapes(mean_dn.shape, variance_dn2.shape), context)
        return (mean_dn - context.black_level_dn) * gain + context.black_level_dn, variance_dn2 * gain**2
