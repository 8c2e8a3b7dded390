"""Colours that are magnified differently."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np

from tacos_framework import ImageContext, ImageGeometry, Settings, Stage, setting
from tacos_framework.camera import Places, resample
from tacos_plugins.effects.samples import Samples

_LARGEST = 0.05
_ROUNDS = 6


class LateralChromaticAberration:
    """Magnifies red and blue against green: a radius becomes ``radius (1 + c + b r^2)``.

    r runs over half the sensor's diagonal. Within a channel all light is treated alike, and mono images
    stay as they are, though a real lens blurs them a little towards the corners.

    Source: Kang 2007, "Automatic removal of chromatic aberration from a single image", CVPR.
    """

    class Config(Settings):
        red: float = setting(0.0, help="c of red; 0.0003 is usual.", ge=-_LARGEST, le=_LARGEST)
        blue: float = setting(0.0, help="c of blue.", ge=-_LARGEST, le=_LARGEST)
        red_r2: float = setting(0.0, help="b of red.", ge=-_LARGEST, le=_LARGEST)
        blue_r2: float = setting(0.0, help="b of blue.", ge=-_LARGEST, le=_LARGEST)

    stage: ClassVar[Stage] = "optics"
    rank: ClassVar[int] = 20
    neutral: ClassVar[Mapping[str, Any]] = {"red": 0.0, "blue": 0.0, "red_r2": 0.0, "blue_r2": 0.0}
    initial_guesses: ClassVar[Sequence[Mapping[str, Any]]] = (
        {"red": 0.001},
        {"blue": 0.001},
        {"red_r2": 0.001},
        {"blue_r2": 0.001},
    )

    def __init__(self, config: Config) -> None:
        self.config = config

    def on_array(
        self, signal: Samples, *, geometry: ImageGeometry, context: ImageContext, rng: np.random.Generator
    ) -> Samples:
        """Light with red and blue magnified; mono light as it was."""
        c = self.config
        moved = {0: (c.red, c.red_r2), 2: (c.blue, c.blue_r2)}
        if signal.shape[-1] != 3 or not any(map(any, moved.values())):
            return signal
        fringed = signal.copy()
        for channel, (constant, square) in moved.items():
            if constant or square:
                places = magnified_source(geometry, constant, square)
                fringed[..., channel] = resample(signal[..., channel : channel + 1], *places)[..., 0]
        return fringed


def magnified_source(geometry: ImageGeometry, constant: float, square: float) -> Places:
    """Places at which pixels of a channel look whose radii are magnified by ``1 + constant + square r^2``.

    `constant`, `square`: c and b, at most 0.05 [1].

    Returns: (H, W) columns and rows [px].

    >>> geometry = ImageGeometry(201, 1, focal_length_px=100, centre_px=(100.0, 0.0), pixel_um=3)
    >>> x, _ = magnified_source(geometry, constant=0.01, square=0.0)
    >>> round(float(x[0, 200]), 3)  # 100 / 1.01 from the middle
    199.01
    """
    radius = geometry.radius
    scale = np.ones_like(radius)
    for _ in range(_ROUNDS):
        scale = 1.0 / (1 + constant + square * (radius * scale) ** 2)
    cx, cy = geometry.centre_px
    return cx + geometry.x_px * scale, cy + geometry.y_px * scale
