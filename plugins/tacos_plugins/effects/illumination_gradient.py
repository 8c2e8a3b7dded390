"""Light that falls unevenly on the scene."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Captures, Estimate, ImageContext, ImageGeometry, Settings, ShownBy, Stage, setting
from tacos_plugins.effects import closed_forms
from tacos_plugins.effects.samples import Samples
from tacos_plugins.effects.shown_by import FALL_OFF


class IlluminationGradient:
    """Multiplies the light by a plane over the image, 1 in the middle of the sensor:

        1 + gx x / width + gy y / height

    with x to the right and y downwards, over the size of the full sensor. A lamp at one side of a flat target
    does this; it stays with the target when the camera is turned, where vignetting turns with the camera.
    The plane is laid over the image, not over the surfaces of the scene.
    """

    class Config(Settings):
        gx: float = setting(0.0, help="Rise from the left to the right edge.", unit="1/width", ge=-2, le=2)
        gy: float = setting(0.0, help="Rise from the top to the bottom edge.", unit="1/height", ge=-2, le=2)

    stage: ClassVar[Stage] = "scene"
    rank: ClassVar[int] = 10
    neutral: ClassVar[Mapping[str, Any]] = {"gx": 0.0, "gy": 0.0}
    initial_guesses: ClassVar[Sequence[Mapping[str, Any]]] = ({"gx": 0.1}, {"gy": 0.1})
    shown_by: ClassVar[Sequence[ShownBy]] = (FALL_OFF,)

    def __init__(self, config: Config) -> None:
        self.config = config

    @classmethod
    def estimate_from(cls, captures: Captures) -> Iterator[Estimate]:
        """The plane that fits walls best beside an even polynomial of the radius."""
        if found := closed_forms.shading(captures):
            yield Estimate("gx", *found.gx, negligible=0.004)
            yield Estimate("gy", *found.gy, negligible=0.004)

    def on_array(
        self, signal: Samples, *, geometry: ImageGeometry, context: ImageContext, rng: np.random.Generator
    ) -> Samples:
        if not (self.config.gx or self.config.gy):
            return signal
        plane = light_plane(geometry, self.config.gx, self.config.gy)
        return signal * plane.astype(signal.dtype)[..., None]


def light_plane(geometry: ImageGeometry, gx: float, gy: float) -> NDArray[np.float64]:
    """Light at each pixel over light in the middle of the sensor.

    `geometry`: the image; the plane runs over the full sensor it is a part of. `gx`, `gy`: rise from edge to
    edge [1/width, 1/height].

    Returns: (H, W) float64, never below 0 [1].

    >>> geometry = ImageGeometry(4, 1, focal_length_px=4.0, centre_px=(1.5, 0.0), pixel_um=3)
    >>> light_plane(geometry, gx=0.4, gy=0.0).round(3).tolist()
    [[0.85, 0.95, 1.05, 1.15]]
    """
    x = (np.arange(geometry.width_px) + geometry.offset_px[0] + 0.5) / geometry.full_width_px - 0.5
    y = (geometry.sensor_row + 0.5) / geometry.full_height_px - 0.5
    return np.maximum(1 + gx * x + gy * y, 0.0)
