"""Plain arrays of light for effects ahead of the noise, and what goes with them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework.camera.resampling import resample
from tacos_framework.contracts import moves_pixels
from tacos_framework.values import ImageContext, ImageGeometry

GEOMETRY = ImageGeometry(96, 72, focal_length_px=80.0, centre_px=(46.0, 37.0), pixel_um=3.0)


def pattern(x_px: NDArray[Any], y_px: NDArray[Any]) -> NDArray[np.float64]:
    """A smooth scene that can be looked up at any place of the image, beyond its borders too."""
    return 10 + 3 * np.cos(0.45 * x_px + 0.1 * y_px) + 2 * np.sin(0.3 * y_px - 0.15 * x_px)


def light(
    place: Callable[..., Any] = pattern, geometry: ImageGeometry = GEOMETRY, channels: int = 3
) -> NDArray[np.float64]:
    """(1, H, W, C) light of a scene."""
    y, x = np.mgrid[: geometry.height_px, : geometry.width_px].astype(np.float64)
    return np.repeat(place(x, y)[None, :, :, None], channels, axis=-1)


def run(effect: type[Any], signal: NDArray[Any], **settings: Any) -> NDArray[Any]:
    """The array after an effect; `geometry`, `context` and `seed` may be given among the settings."""
    geometry = settings.pop("geometry", GEOMETRY)
    context = settings.pop("context", ImageContext())
    rng = np.random.default_rng(settings.pop("seed", 1))
    component = effect(effect.Config(**settings))
    if moves_pixels(effect):
        places = component.source(geometry=geometry, context=context, frames=len(signal))
        return signal if places is None else resample(signal, *places)
    return component.on_array(signal, geometry=geometry, context=context, rng=rng)


INSIDE = np.s_[:, 12:-12, 12:-12]
"""Away from the borders, where light from outside the image plays no part."""
