"""Colour that was sampled through filters and reconstructed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from tacos_framework import ContextMissing, ImageContext, ImageGeometry, Settings, Stage, setting
from tacos_plugins.effects.mosaic import METHODS, mosaic


class Demosaic:
    """Keeps one colour of each pixel, as a sensor under a Bayer mosaic does, and reconstructs the others.

    Interpolated samples have less noise than sampled ones: a lattice of period 2 in the variance, noise
    correlated between neighbours, false colours at fine edges. The methods: ``bilinear``;
    ``gradient-corrected`` (Malvar, He & Cutler 2004), linear as well; ``edge-aware`` (Hamilton & Adams
    1997), which interpolates along edges.

    The mosaic is laid over the pixels of the image it is given. Of a binned camera these are averages of
    photosites already, as of sensors that bin within a colour; a camera that reconstructs colours first and
    averages afterwards has less false colour than this.

    References
    ----------
    Li, Gunturk & Zhang 2008, "Image demosaicing: a systematic survey", Proc. SPIE 6822.
    """

    class Config(Settings):
        """Settings of the effect."""

        method: Literal["none", "bilinear", "gradient-corrected", "edge-aware"] = setting(
            "none", help="How missing colours are reconstructed; none leaves the full colour of every pixel."
        )
        cfa: Literal["RGGB", "GRBG", "GBRG", "BGGR"] = setting(
            "RGGB", help="Colour filters from the top-left pixel of the image on."
        )

    stage: ClassVar[Stage] = "isp"
    rank: ClassVar[int] = 30
    neutral: ClassVar[Mapping[str, Any]] = {"method": "none"}
    initial_guesses: ClassVar[Sequence[Mapping[str, Any]]] = (
        {"method": "bilinear"},
        {"method": "gradient-corrected"},
        {"method": "edge-aware"},
    )

    def __init__(self, config: Config) -> None:
        self.config = config

    def on_array(
        self,
        signal: NDArray[np.floating],
        *,
        geometry: ImageGeometry,
        context: ImageContext,
        rng: np.random.Generator,
    ) -> NDArray[np.floating]:
        """The samples, reconstructed from a mosaic of them."""
        if self.config.method == "none":
            return signal
        if signal.shape[-1] != 3:
            raise ContextMissing("effect.demosaic needs images in colour")
        reconstruct = METHODS[self.config.method]
        return np.stack([reconstruct(mosaic(frame, self.config.cfa), self.config.cfa) for frame in signal])
