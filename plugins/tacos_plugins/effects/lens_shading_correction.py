"""Corners that are lifted in the camera."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from tacos_framework import ImageContext, ImageGeometry, Settings, ShownBy, Stage, setting
from tacos_plugins.effects.radial import darkens, even_polynomial
from tacos_plugins.effects.samples import Moments, Samples
from tacos_plugins.effects.shown_by import FALL_OFF


class LensShadingCorrection:
    """Multiplies the signal by ``1 + k1 r^2 + k2 r^4``, with r over the half diagonal of the sensor.

    It acts on noisy samples: signal and noise rise together, so the variance over the mean rises towards
    the corners, where that of a darker or lighter lens would stay.

    Source: Young 2000, "Shading correction: compensation for illumination and sensor inhomogeneities",
    Current Protocols in Cytometry.
    """

    class Config(Settings):
        k1: float = setting(0.0, help="Coefficient of r^2; 0.5 to 3 for a small lens.", ge=-10, le=100)
        k2: float = setting(0.0, help="Coefficient of r^4.", ge=-100, le=100)

    stage: ClassVar[Stage] = "isp"
    rank: ClassVar[int] = 10
    neutral: ClassVar[Mapping[str, Any]] = {"k1": 0.0, "k2": 0.0}
    initial_guesses: ClassVar[Sequence[Mapping[str, Any]]] = ({"k1": 0.3}, {"k2": 0.3})
    shown_by: ClassVar[Sequence[ShownBy]] = (FALL_OFF,)

    def __init__(self, config: Config) -> None:
        self.config = config

    @property
    def plausible(self) -> bool:
        """True if the gain rises from the centre, or at least does not fall: it makes up for dark corners."""
        return not darkens(self.config.k1, self.config.k2)

    def _gain(self, geometry: ImageGeometry) -> NDArray[np.float64]:
        """(H, W, 1) gain, never below 0 [1]."""
        return even_polynomial(geometry.radius, self.config.k1, self.config.k2)[..., None]

    def on_array(
        self, signal: Samples, *, geometry: ImageGeometry, context: ImageContext, rng: np.random.Generator
    ) -> Samples:
        if self.config.k1 == 0 and self.config.k2 == 0:
            return signal
        gain = self._gain(geometry).astype(signal.dtype)
        return (signal - context.black_level_dn) * gain + context.black_level_dn

    def moments(
        self, mean_dn: Samples, variance_dn2: Samples, *, geometry: ImageGeometry, context: ImageContext
    ) -> Moments:
        """Means with the gain, variances with its square."""
        gain = self._gain(geometry)
        return (mean_dn - context.black_level_dn) * gain + context.black_level_dn, variance_dn2 * gain**2
