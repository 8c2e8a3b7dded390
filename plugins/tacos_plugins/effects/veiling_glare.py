"""Light that strays inside the lens."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_framework import ImageContext, ImageGeometry, Settings, ShownBy, Stage, setting
from tacos_plugins.effects.samples import Samples
from tacos_plugins.effects.shown_by import LEVELS

_COARSE_PX = 64
"""Stray light is smooth: it is spread on an image of this size."""


class VeilingGlare:
    """Takes a share of each pixel's light and spreads it over the image.

        (1 - share) x + share * mean(x)

    per channel, or with `spread` a wide Gaussian in place of the mean. Dark places rise with the light of the
    scene; with the lens cap on nothing happens, unlike with a wrong black level. Lamps outside the image and,
    of a crop, the rest of the sensor are not known and give no glare.

    Source: ISO 9358:1994, veiling glare of image-forming systems.
    """

    class Config(Settings):
        share: float = setting(
            0.0, help="Share of the light that strays; 0.005 to 0.05 is usual.", ge=0, le=1
        )
        spread: float | None = setting(
            None,
            help="Standard deviation of the stray light's spread, in half diagonals; even if not given.",
            ge=0.05,
            le=2,
        )

    stage: ClassVar[Stage] = "optics"
    rank: ClassVar[int] = 50
    neutral: ClassVar[Mapping[str, Any]] = {"share": 0.0}
    initial_guesses: ClassVar[Sequence[Mapping[str, Any]]] = ({"share": 0.03},)
    shown_by: ClassVar[Sequence[ShownBy]] = (LEVELS,)

    def __init__(self, config: Config) -> None:
        self.config = config

    def on_array(
        self, signal: Samples, *, geometry: ImageGeometry, context: ImageContext, rng: np.random.Generator
    ) -> Samples:
        share = self.config.share
        if share == 0.0:
            return signal
        if self.config.spread is None:
            veil = signal.mean(axis=(1, 2), keepdims=True, dtype=np.float64)
        else:
            veil = spread_widely(signal, self.config.spread * geometry.half_diagonal_px)
        return (signal + share * (veil - signal)).astype(signal.dtype)


def spread_widely(light: NDArray[np.floating], sigma_px: float) -> NDArray[np.floating]:
    """Light blurred by a Gaussian as wide as a good part of the image; its mean stays.

    `light`: (N, H, W, C) float32 or float64. `sigma_px`: standard deviation [px].

    Returns: same shape and dtype.
    """
    height, width = light.shape[1:3]
    coarse = (min(width, _COARSE_PX), min(height, max(1, round(_COARSE_PX * height / width))))
    sigma = (sigma_px * coarse[0] / width, sigma_px * coarse[1] / height)
    veil = np.empty_like(light)
    for frame, out in zip(light, veil, strict=True):
        small = cv2.resize(np.ascontiguousarray(frame), coarse, interpolation=cv2.INTER_AREA)
        smooth = cv2.GaussianBlur(small, (0, 0), *sigma, borderType=cv2.BORDER_REFLECT)
        spread = cv2.resize(smooth, (width, height), interpolation=cv2.INTER_LINEAR).reshape(frame.shape)
        lost = frame.mean(axis=(0, 1)) - spread.mean(axis=(0, 1))
        out[...] = spread + lost
    return veil
