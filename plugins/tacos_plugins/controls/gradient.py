"""Exposure control by the gradients of the image."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_framework import Exposure, ImageContext, setting
from tacos_plugins.controls.limits import ExposureLimits, signal_shares

GAMMAS = (1 / 1.9, 1 / 1.5, 1 / 1.2, 1.0, 1.2, 1.5, 1.9)
"""Powers an image is tried with: below 1 it is brighter, as with a longer exposure (Sec. III-B)."""
FINE_GAMMAS = np.linspace(GAMMAS[0], GAMMAS[-1], 201)
"""Powers among which the peak of the curve is searched."""


class Gradient:
    """Seeks the exposure whose image has most gradients, as tasks that live on edges and corners want it.

    The last frame is tried at seven powers, which brighten or darken it as another exposure would. For each
    the gradients are counted by :func:`gradient_information`; a polynomial through the seven says which power
    has most of it, and the exposure goes that way:

        E' = (1 + a K (1 - gamma)) E,   a = 1/2 where gamma >= 1, else 1      (eq. 5)

    It needs no target level: a small bright window does not darken the room before it. What is asked is
    given as exposure time first, and as gain where the time is at its limit.

    Source: Shim, Lee, Kweon 2014, "Auto-adjusting camera exposure for outdoor robotics using gradient
    information", IROS. The authors give lambda = 1000 and sigma = 0.06; frames here are linear, where dark
    gradients are smaller, hence the default for sigma.
    """

    class Config(ExposureLimits):
        gain: float = setting(
            0.8, help="Gain of the loop (K); a large one is quick and may oscillate.", gt=0, le=2
        )
        threshold: float = setting(
            0.03, help="Gradients below this share of full scale are noise (sigma).", ge=0, lt=1
        )
        emphasis: float = setting(
            1000.0, help="Emphasis of weak gradients beside strong ones (lambda).", gt=0, le=1e9
        )
        metered_px: int = setting(
            160,
            help="Width at which images are metered; noise averages out, and time is saved.",
            unit="px",
            ge=16,
        )

    def __init__(self, config: Config) -> None:
        self.config = config

    @property
    def warm_up_frames(self) -> int:
        return self.config.warm_up_frames

    def adjust(
        self, frame_dn: NDArray[np.unsignedinteger], *, exposure: Exposure, context: ImageContext
    ) -> Exposure:
        config = self.config
        gamma = self.best_gamma(_smaller(signal_shares(frame_dn, context), config.metered_px))
        step = (0.5 if gamma >= 1 else 1.0) * config.gain * (1 - gamma)  # eq. 5
        return config.exposure(exposure.time_s * exposure.gain * (1 + step), exposure.f_number)

    def best_gamma(self, image: NDArray[np.float32]) -> float:
        """The power at which an (H, W) image within 0..1 has most gradient information."""
        config = self.config
        found = [gradient_information(image**gamma, config.threshold, config.emphasis) for gamma in GAMMAS]
        if max(found) == 0:  # black or full: there is but one way out
            return GAMMAS[0] if image.mean() < 0.5 else GAMMAS[-1]
        curve = np.polynomial.Polynomial.fit(GAMMAS, found, 5)
        return float(FINE_GAMMAS[np.argmax(curve(FINE_GAMMAS))])


def gradient_information(image: NDArray[np.float32], threshold: float, emphasis: float) -> float:
    """Sum of the logarithm of gradients above a threshold, over the number of pixels.

        m' = log(lambda (m - sigma) + 1) / log(lambda (1 - sigma) + 1)   where m >= sigma, else 0   (eq. 1, 2)

    `image`: (H, W) within 0..1. `threshold`, `emphasis`: sigma and lambda [1].

    >>> step = np.repeat(np.float32([[0, 0, 1, 1]]), 4, axis=0)
    >>> gradient_information(step, 0.06, 1000.0) > gradient_information(step / 2, 0.06, 1000.0) > 0
    True
    """
    right, down = (
        cv2.Sobel(image, cv2.CV_32F, 1, 0, scale=1 / 4),
        cv2.Sobel(image, cv2.CV_32F, 0, 1, scale=1 / 4),
    )
    magnitude = np.minimum(cv2.magnitude(right, down), 1.0)
    counted = magnitude[magnitude >= max(threshold, 1e-6)] - threshold
    weighed = np.log1p(emphasis * counted) / np.log1p(emphasis * (1 - threshold))
    return float(weighed.sum()) / image.size


def _smaller(image: NDArray[np.float32], width_px: int) -> NDArray[np.float32]:
    """An image averaged down to a width; itself where it is no wider."""
    height, width = image.shape
    if width <= width_px:
        return image
    size = (width_px, max(1, round(height * width_px / width)))
    return np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), np.float32)
