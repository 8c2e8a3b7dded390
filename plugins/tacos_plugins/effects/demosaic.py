"""Colour that was sampled through filters and reconstructed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, Literal

import numpy as np

from tacos_framework import ContextMissing, ImageContext, ImageGeometry, Settings, Stage, setting
from tacos_plugins.effects.mosaic import METHODS, mosaic
from tacos_plugins.effects.samples import Samples


class Demosaic:
    """Keeps one colour of each pixel, as a sensor under a Bayer mosaic does, and reconstructs the others.

    Interpolated samples have less noise than sampled ones: a lattice of period 2 in the variance, noise
    correlated between neighbours, false colours at fine edges. The methods: ``bilinear``;
    ``gradient-corrected`` (Malvar, He & Cutler 2004), linear as well; ``edge-aware`` (Hamilton & Adams
    1997), which interpolates along edges.

    The mosaic is laid over the camera's own pixels; those of a camera that bins are averages already, as of
    sensors that bin within a colour. Where blocks of the camera's pixels are simulated as one, colours were
    reconstructed before they were averaged: it is off then, and the sensor gives the averages their noise.

    Source: Li, Gunturk & Zhang 2008, "Image demosaicing: a systematic survey", Proc. SPIE 6822.
    """

    class Config(Settings):
        method: Literal["none", "bilinear", "gradient-corrected", "edge-aware"] = setting(
            "none", help="Reconstruction of missing colours; none leaves the full colour of every pixel."
        )
        cfa: Literal["RGGB", "GRBG", "GBRG", "BGGR"] = setting(
            "RGGB", help="Colour filters from the top-left pixel of the image on."
        )

    stage: ClassVar[Stage] = "isp"
    rank: ClassVar[int] = 30
    of_colours: ClassVar[bool] = True
    neutral: ClassVar[Mapping[str, Any]] = {"method": "none"}
    initial_guesses: ClassVar[Sequence[Mapping[str, Any]]] = (
        {"method": "bilinear"},
        {"method": "gradient-corrected"},
        {"method": "edge-aware"},
    )

    def __init__(self, config: Config) -> None:
        self.config = config

    def on_array(
        self, signal: Samples, *, geometry: ImageGeometry, context: ImageContext, rng: np.random.Generator
    ) -> Samples:
        """The samples, reconstructed from a mosaic of them."""
        if self.config.method == "none" or geometry.simulated_binning > 1:
            return signal
        if signal.shape[-1] != 3:
            raise ContextMissing("effect.demosaic needs images in colour")
        reconstruct = METHODS[self.config.method]
        return np.stack([reconstruct(mosaic(frame, self.config.cfa), self.config.cfa) for frame in signal])
