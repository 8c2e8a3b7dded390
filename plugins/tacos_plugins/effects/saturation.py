"""Pixels that are full below full scale."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import ndtr

from tacos_framework import Captures, ImageContext, ImageGeometry, Settings, ShownBy, Stage, physical, setting
from tacos_plugins.effects.samples import Moments, Samples
from tacos_plugins.effects.shown_by import BRACKET

_SHARED = 0.01
"""Share of pixels within two codes of the largest value from which on they pile up there."""

_FEWEST_PX = 25
_SPIKE = 5.0
"""Pixels at the largest value, over those at each code of a hundredth of it below, of a pile of fewer."""


def _pile_up(values_dn: NDArray[np.floating], top_dn: float) -> bool:
    """True if many pixels are cut off at their largest value, or few, but far more than just below it."""
    if np.mean(values_dn >= top_dn - 2) > _SHARED:
        return True
    codes = max(np.ceil(0.01 * top_dn), 4.0)
    at_top = int(np.sum(values_dn == top_dn))
    below = int(np.sum(values_dn >= top_dn - codes)) - at_top
    return at_top >= _FEWEST_PX and at_top > _SPIKE * below / codes


class Saturation:
    """Cuts noisy samples off at a level: the photosites' full well, or an amplifier's end.

    Electrons above the full well are lost once they are counted, so the effect follows the noise: samples
    pile up at the level and their variance goes to zero. From the file's white level on it changes nothing
    that the file would not cut off itself. Of a binned pixel it is the average that is cut off, where a
    camera cuts off each photosite: close to the level, within the noise, the average comes out too high by a
    fraction of that noise.

    Source: EMVA 1288, release 4.0: the saturation point is where the variance falls. Foi 2009, "Clipped noisy
    images", Signal Processing 89(12): moments of clipped samples.
    """

    class Config(Settings):
        level_dn: float | None = setting(
            None,
            help="Level at which pixels are full, pedestal included; the white level by default.",
            unit="DN",
            with_pedestal=True,
            gt=0,
        )
        level_e: float | None = physical(
            "level_dn", help="Electrons above the pedestal at which pixels are full.", unit="e-", gt=0
        )

    stage: ClassVar[Stage] = "pixel"
    after_noise: ClassVar[bool] = True
    rank: ClassVar[int] = 50
    neutral: ClassVar[Mapping[str, Any]] = {"level_dn": None}
    initial_guesses: ClassVar[Sequence[Mapping[str, Any]]] = ()
    shown_by: ClassVar[Sequence[ShownBy]] = (BRACKET,)

    def __init__(self, config: Config) -> None:
        self.config = config

    @classmethod
    def guesses_from(cls, captures: Captures) -> Iterator[Mapping[str, Any]]:
        """The value that many pixels of a channel share at the top of a capture, below full scale.

        Gains of colours that follow part the channels, and may bring one of them to full scale.
        """
        found = set()
        for capture in captures:
            for values_dn in np.moveaxis(capture.real_dn, -1, 0):
                top = float(values_dn.max())
                if top < capture.context.white_level_dn and _pile_up(values_dn, top):
                    found.add(top)
        for level in sorted(found)[-2:]:
            yield {"level_dn": level}

    def on_array(
        self, signal: Samples, *, geometry: ImageGeometry, context: ImageContext, rng: np.random.Generator
    ) -> Samples:
        level = self.config.level_dn
        if level is None or level >= context.white_level_dn:
            return signal
        return np.minimum(signal, signal.dtype.type(level))

    def moments(
        self, mean_dn: Samples, variance_dn2: Samples, *, geometry: ImageGeometry, context: ImageContext
    ) -> Moments:
        """Moments of a Gaussian that is cut off."""
        level = self.config.level_dn
        if level is None or level >= context.white_level_dn:
            return mean_dn, variance_dn2
        return cut_off_moments(mean_dn, variance_dn2, level)


def cut_off_moments(mean_dn: ArrayLike, variance_dn2: ArrayLike, level_dn: float) -> Moments:
    """Mean and variance of ``min(x, level)`` for Gaussian x.

    `mean_dn`, `variance_dn2`: moments of x; they broadcast [DN, DN^2]. `level_dn`: where x is cut off [DN].

    At the level, half of the noise is left:

    >>> mean, variance = cut_off_moments(100.0, 4.0, 100.0)
    >>> mean.round(4).item(), variance.round(4).item()
    (99.2021, 1.3634)
    """
    mean, variance = np.broadcast_arrays(
        np.asarray(mean_dn, np.float64), np.asarray(variance_dn2, np.float64)
    )
    deviation = np.sqrt(variance)
    with np.errstate(divide="ignore", invalid="ignore"):
        z = np.where(deviation > 0, (level_dn - mean) / deviation, np.where(mean > level_dn, -np.inf, np.inf))
    below = ndtr(z)
    density = np.exp(-(z**2) / 2) / np.sqrt(2 * np.pi)
    # First and second moment of min(x - level, 0) / deviation.
    beyond = np.where(np.isfinite(z), z, 0.0)
    first = -(beyond * below + density)
    second = (beyond**2 + 1) * below + beyond * density
    cut_mean = np.where(np.isposinf(z), mean, level_dn + deviation * first)
    return cut_mean, variance * np.where(np.isposinf(z), 1.0, np.maximum(second - first**2, 0.0))
