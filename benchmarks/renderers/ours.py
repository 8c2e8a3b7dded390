"""`renderer.moderngl` as it is."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from renderers import Picture
from renderers.tour import Tour
from tacos_framework import Exposure, Rig, View
from tacos_plugins.renderers.moderngl.renderer import ModernglRenderer


class Ours:
    """Baked light with shadows and reflections; radiance in floats; antialiased edges; always with ids."""

    def __init__(self, tour: Tour) -> None:
        self._tour = tour
        self._rig = Rig((tour.camera,))
        self._renderer = ModernglRenderer(ModernglRenderer.Config())

    def draw(self, frame: int, ids: bool) -> View:
        """One view."""
        at = self._tour.frames[frame]
        episode = self._tour.episode[at : at + 1]
        return self._renderer.capture(episode, rig=self._rig, exposure=Exposure()).views[0]

    def picture(self, drawn: View) -> Picture:
        """Its luminance, exposed for the 97th percentile."""
        luminance = drawn.luminance_cd_m2[0]
        return Picture(srgb(luminance / np.quantile(luminance, 0.97)), drawn.depth_m[0], drawn.object_id[0])


def srgb(linear: NDArray[np.float32]) -> NDArray[np.uint8]:
    """8-bit sRGB of linear light, 1 as white (IEC 61966-2-1)."""
    light = np.clip(linear, 0, 1)
    encoded = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    return np.rint(255 * encoded).astype(np.uint8)
