"""Light that falls off towards the corners."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from tacos_framework.contracts import Stage
from tacos_framework.settings import Settings, setting
from tacos_framework.values import Camera, Capture, Exposure, Rig, View


class Vignetting:
    """Multiplies the light by ``1 + k1 r^2 + k2 r^4 + k3 r^6``, with r over half the image's diagonal.

    The fall-off is centred on the principal point. It dims light, before the noise: the noise in
    the corners is that of their lower signal.

    References
    ----------
    Goldman 2010, "Vignette and exposure calibration and compensation", IEEE Trans. PAMI 32(12): the even
    polynomial of third order.
    """

    class Config(Settings):
        """Settings of the effect."""

        k1: float = setting(0.0, help="Coefficient of r^2; about -0.4 for a small wide lens.")
        k2: float = setting(0.0, help="Coefficient of r^4.")
        k3: float = setting(0.0, help="Coefficient of r^6.")

    stage: ClassVar[Stage] = "optics"
    neutral: ClassVar[Mapping[str, Any]] = {"k1": 0.0, "k2": 0.0, "k3": 0.0}

    def __init__(self, config: Config) -> None:
        self.config = config

    def apply(self, image: Capture, *, rig: Rig, exposure: Exposure, rng: np.random.Generator) -> Capture:
        """The capture with the fall-off in every view; the capture itself where the effect is off."""
        if not any((self.config.k1, self.config.k2, self.config.k3)):
            return image
        return replace(image, views=tuple(self._dim(view) for view in image.views))

    def _dim(self, view: View) -> View:
        field = relative_illumination(view.camera, self.config.k1, self.config.k2, self.config.k3)
        light = view.luminance_cd_m2 * field.astype(np.float32)[..., None]
        return replace(view, luminance_cd_m2=light)


def relative_illumination(camera: Camera, k1: float, k2: float, k3: float) -> NDArray[np.float64]:
    """Light at each pixel over light at the principal point.

    Parameters
    ----------
    camera
        The camera; its principal point is the centre.
    k1, k2, k3
        Coefficients of r^2, r^4 and r^6 [1].

    Returns
    -------
    NDArray
        (H, W) float64, never below 0 [1].

    Examples
    --------
    >>> camera = Camera("c", width_px=3, height_px=3, pixel_um=3, focal_length_mm=4)
    >>> relative_illumination(camera, k1=-0.45, k2=0, k3=0).round(3).tolist()
    [[0.8, 0.9, 0.8], [0.9, 1.0, 0.9], [0.8, 0.9, 0.8]]
    """
    cx, cy = camera.centre_px
    x_px = np.arange(camera.width_px) - cx
    y_px = np.arange(camera.height_px)[:, None] - cy
    half_diagonal_px = np.hypot(camera.width_px, camera.height_px) / 2
    r2 = (x_px**2 + y_px**2) / half_diagonal_px**2
    return np.maximum(1 + r2 * (k1 + r2 * (k2 + r2 * k3)), 0.0)
