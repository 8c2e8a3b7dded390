"""Noise taken out of flat parts of the image."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any, ClassVar, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_framework import (
    Captures,
    Estimate,
    ImageContext,
    ImageGeometry,
    Settings,
    ShownBy,
    Stage,
    of_kind,
    setting,
)
from tacos_plugins.effects import closed_forms
from tacos_plugins.effects.samples import Samples
from tacos_plugins.effects.shown_by import REPEATED_FLAT

_STRIDE = 2  # places between these tell little more of the noise
_LEVELS = 8
_SECOND_DIFFERENCE = np.array([[1.0, -2.0, 1.0], [-2.0, 4.0, -2.0], [1.0, -2.0, 1.0]])
_SIGMA_OF_MEDIAN = 1 / (0.6745 * 6)  # the squares of the weights above come to 36


class Denoise:
    """Adaptive Wiener filter: flat parts become their mean, edges stay.

        y = m + max(v - s n - t^2, 0) / v (x - m)

    with m and v the mean and variance of the samples in a window, n the variance of the noise at that level
    as found in the image, s the strength and t the threshold. In flat parts the noise shrinks and what is
    left of it is correlated; texture fainter than the noise goes with it, while strong edges keep both
    sharpness and noise. Software that knows how noise grows with light has a strength; software that does
    not has a threshold, and smooths the dark where it leaves the noise of bright parts. The filter was chosen
    over bilateral or non-local ones because its numbers have a meaning, and because it is fast.

    The window counts pixels of the image it is given: at another binning the filter is another one, as is
    that of a camera whose processing follows the binning.

    Sources: Lee 1980, "Digital image enhancement and noise filtering by use of local statistics", IEEE Trans.
    PAMI 2(2). Immerkaer 1996, "Fast noise variance estimation", CVIU 64(2): noise where there is texture.
    """

    class Config(Settings):
        strength: float = setting(
            0.0, help="Variance taken for noise over that found; 1 is the Wiener filter.", ge=0, le=10
        )
        threshold: float = setting(
            0.0, help="Deviation taken for noise at every level, over the range of codes.", ge=0, le=0.2
        )
        window: Literal[3, 5, 7] = setting(5, help="Samples along an edge of the window.")

    stage: ClassVar[Stage] = "isp"
    rank: ClassVar[int] = 40
    neutral: ClassVar[Mapping[str, Any]] = {"strength": 0.0, "threshold": 0.0}
    initial_guesses: ClassVar[Sequence[Mapping[str, Any]]] = (
        {"strength": 0.2},
        {"strength": 1.0},
        {"strength": 3.0},
        {"strength": 1.0, "window": 3},
        {"threshold": 0.004},
        {"threshold": 0.015},
    )
    shown_by: ClassVar[Sequence[ShownBy]] = (REPEATED_FLAT,)

    def __init__(self, config: Config) -> None:
        self.config = config

    @classmethod
    def estimate_from(cls, captures: Captures) -> Iterator[Estimate]:
        """None, where the noise of neighbours in walls is independent; else it tells not how much.

        Walls say nothing of a threshold that only the fainter noise of darks lies below.
        """
        if closed_forms.is_white(captures):
            yield Estimate("strength", 0.0, 0.0, negligible=0.01)
            if any(dark.frames > 1 for dark in of_kind(captures, "dark")):
                yield Estimate("threshold", 0.0, 1.0, negligible=0.001)

    def on_array(
        self, signal: Samples, *, geometry: ImageGeometry, context: ImageContext, rng: np.random.Generator
    ) -> Samples:
        strength, threshold = self.config.strength, self.config.threshold
        if strength == threshold == 0:
            return signal
        threshold_dn2 = (threshold * (context.white_level_dn - context.black_level_dn)) ** 2
        smooth = np.empty_like(signal)
        for frame, out in zip(signal, smooth, strict=True):
            out[:] = wiener(frame, strength, threshold_dn2, self.config.window)
        return smooth


def wiener(
    frame: NDArray[np.floating], strength: float, threshold_dn2: float, window: int
) -> NDArray[np.floating]:
    """One (H, W, C) frame, each channel filtered by itself.

    `threshold_dn2`: variance taken for noise at all levels, beside `strength` times that found [DN^2].
    """
    mean = _local_mean(frame, window)
    variance = np.maximum(_local_mean(frame * frame, window) - mean * mean, 0)
    taken = strength * noise_of_levels(frame, mean) + threshold_dn2 if strength else threshold_dn2
    kept = np.maximum(variance - taken, 0)
    kept /= np.maximum(variance, np.finfo(frame.dtype).tiny)
    return mean + kept * (frame - mean)


def _local_mean(frame: NDArray[np.floating], window: int) -> NDArray[np.floating]:
    blurred = np.asarray(cv2.blur(frame, (window, window), borderType=cv2.BORDER_REFLECT), frame.dtype)
    return blurred[..., None] if blurred.ndim == 2 else blurred  # OpenCV drops an axis of one channel


def noise_of_levels(frame: NDArray[np.floating], mean: NDArray[np.floating]) -> NDArray[np.floating]:
    """Variance of the noise at each place, as it is at other places as bright.

    Texture hardly enters: a second difference in both directions leaves out slopes and straight edges, and of
    each level the median counts.

    `frame`, `mean`: (H, W, C) samples and their local means [DN].

    Returns: (H, W, C) variance, as a function of `mean` alone [DN^2].
    """
    rough = cv2.filter2D(frame, -1, _SECOND_DIFFERENCE, borderType=cv2.BORDER_REFLECT).reshape(frame.shape)
    found = np.empty_like(frame)
    for channel in range(frame.shape[2]):
        level = mean[::_STRIDE, ::_STRIDE, channel].ravel()
        size = np.abs(rough[::_STRIDE, ::_STRIDE, channel]).ravel()
        groups = min(_LEVELS, len(level))
        of_group = np.argsort(level, kind="stable")[: len(level) // groups * groups].reshape(groups, -1)
        at = np.median(level[of_group], axis=1)
        sigma = _SIGMA_OF_MEDIAN * np.median(size[of_group], axis=1)
        found[..., channel] = _between(mean[..., channel], at, np.square(sigma))
    return found


def _between(
    x: NDArray[np.floating], at: NDArray[np.floating], values: NDArray[np.floating]
) -> NDArray[np.floating]:
    """`numpy.interp` between few places, a slope at a time: four times as fast."""
    found = np.full_like(x, values[0])
    for (start, first), (end, last) in pairwise(zip(at, values, strict=True)):
        if end > start:
            found += np.clip(x - start, 0, end - start) * ((last - first) / (end - start))
    return found
