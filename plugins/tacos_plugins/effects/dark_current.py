"""Charge that gathers without light."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.stats import poisson

from tacos_framework import (
    SURE,
    Captures,
    ImageContext,
    ImageGeometry,
    Settings,
    ShownBy,
    Stage,
    generator,
    physical,
    setting,
)
from tacos_plugins.effects import closed_forms
from tacos_plugins.effects.darks import SteadyDark, steady_darks
from tacos_plugins.effects.fixed_pattern import PatternSettings, in_image, pixel_pattern
from tacos_plugins.effects.samples import Moments, Samples
from tacos_plugins.effects.shown_by import DARKS_OF_TWO_TIMES

_MOST_HIDDEN = 3.0
"""Logarithm of how many more hot pixels there may be than are seen."""

_LEAST_RISE_DN = 0.25
_MOST_UNEVEN = 2.0
"""What captures suggest at most; beyond it, hot pixels are what differs."""


def _rate(first: SteadyDark, last: SteadyDark) -> float | None:
    """Rise of the mean level per second, hot pixels aside; None where it is too small to be seen."""
    rise_dn = last.level_dn - first.level_dn
    time_s = last.capture.context.exposure_s - first.capture.context.exposure_s
    return rise_dn / time_s if time_s > 0 and rise_dn > _LEAST_RISE_DN else None


def _nonuniformity(first: SteadyDark, last: SteadyDark, rate_dn_s: float) -> float:
    """Spread of the pixels' rates over their mean, by how the variance of the pattern has grown."""
    short, long = (closed_forms.pattern_variance([dark.capture], relative=False) for dark in (first, last))
    if short is None or long is None:
        return 0.0
    grown_dn2 = long.value - short.value
    if grown_dn2 < SURE * math.hypot(long.standard_error, short.standard_error):
        return 0.0
    grown_s2 = last.capture.context.exposure_s**2 - first.capture.context.exposure_s**2
    return min(math.sqrt(grown_dn2 / grown_s2) / rate_dn_s, _MOST_UNEVEN)


class DarkCurrent:
    """Adds a signal that grows with the exposure time, strongly in a few hot pixels.

        dark = (rate of the pixel + hot rate of the pixel) * exposure time

    It acts before the noise, so it brings photon noise of its own. Pixels keep their rates, frame after
    frame. Rates are lognormal about their mean; those of hot pixels come on top and are exponential, which is
    the long tail that EMVA 1288 shows in logarithmic histograms. Rates in DN are those at the gain in use. A
    binned pixel averages as many hot photosites as chance has put there.

    Sources: EMVA 1288, release 4.0: dark current, and logarithmic histograms of defect pixels; Widenhorn et
    al. 2002, "Temperature dependence of dark current in a CCD" (skewed distributions of rates).
    """

    class Config(Settings):
        rate_dn_s: float = setting(
            0.0, help="Mean dark signal of the pixels per second.", unit="DN/s", ge=0, le=1e6
        )
        nonuniformity: float = setting(
            0.0,
            help="Standard deviation of the photosites' rates over their mean, hot ones aside (DCNU).",
            averaging="photosites",
            ge=0,
            le=3,
        )
        hot_share: float = setting(0.0, help="Share of hot photosites; 1e-5 to 1e-3 is usual.", ge=0, le=1)
        hot_rate_dn_s: float = setting(
            300.0, help="Mean further dark signal of the hot pixels per second.", unit="DN/s", gt=0
        )
        rate_e_s: float | None = physical(
            "rate_dn_s", help="Mean dark current of the photosites.", unit="e-/s", ge=0, le=1e9
        )
        hot_rate_e_s: float | None = physical(
            "hot_rate_dn_s", help="Mean further dark current of the hot photosites.", unit="e-/s", gt=0
        )
        map_seed: int = setting(
            0, help="Names the individual sensor: the same seed has the same hot pixels.", ge=0
        )

    stage: ClassVar[Stage] = "pixel"
    rank: ClassVar[int] = 20
    neutral: ClassVar[Mapping[str, Any]] = {"rate_dn_s": 0.0, "nonuniformity": 0.0, "hot_share": 0.0}
    initial_guesses: ClassVar[Sequence[Mapping[str, Any]]] = (
        {"rate_dn_s": 10.0},
        {"rate_dn_s": 1.0, "hot_share": 0.0002, "hot_rate_dn_s": 100.0},
        {"rate_dn_s": 0.0, "hot_share": 0.0002, "hot_rate_dn_s": 20.0},
        {"rate_dn_s": 0.0, "hot_share": 0.0002, "hot_rate_dn_s": 200.0},
    )
    shown_by: ClassVar[Sequence[ShownBy]] = (DARKS_OF_TWO_TIMES,)

    def __init__(self, config: Config) -> None:
        self.config = config

    @classmethod
    def guesses_from(cls, captures: Captures) -> Iterator[Mapping[str, Any]]:
        """Rise of the dark and its pattern from the shortest to the longest exposure, and hot pixels there.

        Of exponentially distributed values those above a threshold exceed it by their mean.
        """
        darks = steady_darks(captures)
        if len(darks) > 1 and (rate_dn_s := _rate(darks[0], darks[-1])) is not None:
            yield {"rate_dn_s": rate_dn_s, "nonuniformity": _nonuniformity(darks[0], darks[-1], rate_dn_s)}
        for dark in darks[-1:]:
            hot_dn = dark.hot_dn
            if hot_dn.size:
                mean_dn = float(hot_dn.mean()) - dark.lowest_dn
                hidden = math.exp(min(dark.lowest_dn / mean_dn, _MOST_HIDDEN))
                share = min(hidden * hot_dn.size / dark.above_dn.size, 0.5)
                rate_dn_s = mean_dn / dark.capture.context.exposure_s
                yield {"rate_dn_s": 0.0, "hot_share": share, "hot_rate_dn_s": rate_dn_s}

    def on_array(
        self, signal: Samples, *, geometry: ImageGeometry, context: ImageContext, rng: np.random.Generator
    ) -> Samples:
        if self.config.rate_dn_s == 0 and self.config.hot_share == 0:
            return signal
        return signal + self._dark_dn(geometry, context, signal.shape[-1]).astype(signal.dtype)

    def moments(
        self, mean_dn: Samples, variance_dn2: Samples, *, geometry: ImageGeometry, context: ImageContext
    ) -> Moments:
        """Means with the dark signal; its noise is added with that of the light."""
        if self.config.rate_dn_s == 0 and self.config.hot_share == 0:
            return mean_dn, variance_dn2
        return mean_dn + self._dark_dn(geometry, context, mean_dn.shape[-1]), variance_dn2

    def _dark_dn(self, geometry: ImageGeometry, context: ImageContext, channels: int) -> NDArray[np.float32]:
        """(H, W, C) dark signal [DN]."""
        c, g = self.config, geometry
        size = (g.full_height_px, g.full_width_px, channels)
        hot = _hot_rates(c.map_seed, g.camera, size, c.hot_share, g.binning)
        rate = c.rate_dn_s * self._unevenness(geometry, channels) + c.hot_rate_dn_s * in_image(hot, geometry)
        return np.asarray(rate * np.float32(context.exposure_s))

    def _unevenness(self, geometry: ImageGeometry, channels: int) -> NDArray[np.float32] | float:
        """(H, W, C) lognormal rates over their mean."""
        if not (self.config.rate_dn_s and self.config.nonuniformity):
            return 1.0
        sigma = math.sqrt(math.log1p(self.config.nonuniformity**2))
        own = PatternSettings(map_seed=self.config.map_seed)
        pattern = pixel_pattern("dark-current-rates", own, geometry, channels)
        return np.exp(np.float32(sigma) * pattern - np.float32(sigma**2 / 2))


@lru_cache(maxsize=4)
def _hot_rates(
    seed: int, camera: str, size: tuple[int, int, int], share: float, binning: float
) -> NDArray[np.float32]:
    """(H, W, C) extra rates over the mean of a hot photosite's, 0 where none is hot.

    Positions are an order of all pixels of which a larger share takes more: hot pixels of a smaller share
    stay hot.
    """
    rng = generator(seed, "pattern", "dark-current", camera)
    heat = rng.random(size, np.float32)
    if binning == 1.0:
        rates = rng.standard_exponential(size, np.float32)
        rates *= heat < share
    else:
        photosites = binning**2
        expected = share * photosites
        odds = poisson.cdf(np.arange(expected + 10 * math.sqrt(expected) + 10), expected)
        hot = np.searchsorted(odds, 1 - heat)  # how many of them fall into a pixel
        rates = np.zeros(size, np.float32)
        rates[hot > 0] = rng.standard_gamma(hot[hot > 0]) / photosites
    rates.flags.writeable = False
    return rates
