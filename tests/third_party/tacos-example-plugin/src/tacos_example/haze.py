"""Light lost on its way through hazy air."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray
from tacos_framework import (
    Captures,
    ContextMissing,
    ImageContext,
    ImageGeometry,
    LookAlike,
    Settings,
    ShownBy,
    Stage,
    setting,
    structured,
)


def _distances_known(captures: Captures) -> bool:
    return any(capture.context.depth_m is not None for capture in structured(captures))


def _one_distance(captures: Captures) -> bool:
    """Whether all that is seen is equally far: air then looks like stray light in the lens."""
    depths = [c.context.depth_m for c in structured(captures) if c.context.depth_m is not None]
    return not depths or max(np.max(d) for d in depths) < 1.2 * min(np.min(d) for d in depths)


class Haze:
    """Mixes the light with that of the air, more of it the farther away a thing is:

        L = L0 t + A (1 - t),    t = exp(-b d)

    with d the distance, b the extinction and A the light of the air, a multiple of the mean of the image.

    Source: Koschmieder 1924, "Theorie der horizontalen Sichtweite".
    """

    class Config(Settings):
        extinction_per_m: float = setting(
            0.0, help="Extinction of the air; 0.004 in fog.", unit="1/m", ge=0, le=10
        )
        airlight: float = setting(1.0, help="Light of the air over the mean of the image.", ge=0)

    stage: ClassVar[Stage] = "scene"
    neutral: ClassVar[Mapping[str, Any]] = {"extinction_per_m": 0.0}
    initial_guesses: ClassVar[Sequence[Mapping[str, Any]]] = ({"extinction_per_m": 0.02},)
    look_alikes: ClassVar[Sequence[LookAlike]] = (
        LookAlike("veiling-glare", _one_distance, "scene", "air takes more from what is farther away"),
    )
    shown_by: ClassVar[Sequence[ShownBy]] = (
        ShownBy(_distances_known, "kind scene: things at several distances, with their depth"),
    )

    def __init__(self, config: Config) -> None:
        self.config = config

    def on_array(
        self,
        light: NDArray[Any],
        *,
        geometry: ImageGeometry,
        context: ImageContext,
        rng: np.random.Generator,
    ) -> NDArray[Any]:
        """(N, H, W, C) light seen through haze, of the same shape and type; needs the depth."""
        if self.config.extinction_per_m == 0:
            return light
        if context.depth_m is None:
            raise ContextMissing("haze needs the distance of what each pixel shows")
        per_depth = np.sqrt(1 + (geometry.x_px**2 + geometry.y_px**2) / geometry.focal_length_px**2)
        kept = np.exp(-self.config.extinction_per_m * context.depth_m * per_depth)[..., None]
        air = self.config.airlight * light.mean(axis=(-3, -2), keepdims=True)
        return np.asarray(light * kept + air * (1 - kept)).astype(light.dtype)
