"""Noise of the read-out beyond what the sensor model holds."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, ClassVar

import numpy as np

from tacos_framework import Captures, ImageContext, ImageGeometry, Settings, Stage, physical, setting
from tacos_plugins.effects.samples import Moments, Samples

_HEAVIEST_TAIL = 0.245
"""Of those with a kurtosis that is taken for one without [1]."""


class ReadNoise:
    """Adds noise to every sample, alike in the dark and in the light.

    Noise that arises before the gain (`sigma_dn`, `sigma_e`) grows with it, that of the amplifiers and
    converters after it (`after_gain_dn`) is alike at every gain. Captures at two gains tell them apart.

    With a `tail` the noise follows Student's t distribution of 1 / tail degrees of freedom, scaled to the
    same variance: the rare large values of random telegraph noise. At tail t below 1/4 its excess kurtosis
    is 6 t / (1 - 4 t). The mean of n photosites in a binned pixel has that kurtosis over n; above 1/4, where
    there is none, that of nearly 1/4 is taken for it.

    Source: EMVA 1288, release 4.0: dark noise. Wei et al. 2020, "A physics-based noise formation model for
    extreme low-light raw denoising", CVPR: read noise has longer tails than a Gaussian.
    """

    class Config(Settings):
        sigma_dn: float = setting(
            0.0,
            help="Standard deviation of the noise added to each photosite.",
            unit="DN",
            averaging="photosites",
            ge=0,
            le=65535,
        )
        sigma_e: float | None = physical(
            "sigma_dn", help="The same in electrons, in place of sigma_dn.", unit="e-", ge=0, le=1e6
        )
        after_gain_dn: float = setting(
            0.0,
            help="Standard deviation of noise that arises after the gain.",
            unit="DN",
            averaging="photosites",
            ge=0,
            le=65535,
        )
        after_gain_share: float | None = physical(
            "after_gain_dn",
            help="The same as a share of the file's codes, in place of after_gain_dn.",
            unit="of full scale",
            ge=0,
            le=1,
        )
        tail: float = setting(
            0.0, help="Weight of the tails: 1 / degrees of freedom; 0 is Gaussian.", ge=0, le=0.45
        )

    stage: ClassVar[Stage] = "readout"
    rank: ClassVar[int] = 20
    neutral: ClassVar[Mapping[str, Any]] = {"sigma_dn": 0.0, "after_gain_dn": 0.0, "tail": 0.0}
    initial_guesses: ClassVar[Sequence[Mapping[str, Any]]] = (
        {"sigma_dn": 1.0},
        {"sigma_dn": 1.0, "tail": 0.05},
    )

    def __init__(self, config: Config) -> None:
        self.config = config

    @classmethod
    def guesses_from(cls, captures: Captures) -> Iterator[Mapping[str, Any]]:
        """Noise after the gain, where captures at several gains tell it from that before."""
        if len({capture.context.gain_db for capture in captures}) > 1:
            yield {"after_gain_dn": 1.0}
            yield {"sigma_dn": 1.0, "after_gain_dn": 1.0}

    @property
    def variance_dn2(self) -> float:
        """Of both together [DN^2]."""
        return self.config.sigma_dn**2 + self.config.after_gain_dn**2

    def on_array(
        self, signal: Samples, *, geometry: ImageGeometry, context: ImageContext, rng: np.random.Generator
    ) -> Samples:
        if self.variance_dn2 == 0:
            return signal
        noise = rng.standard_normal(signal.shape, np.float32)
        if self.config.tail:
            freedom = 1 / tail_of_mean(self.config.tail, geometry.binning**2)
            spread = rng.standard_gamma(freedom / 2, signal.shape, np.float32)  # half of chi squared
            noise *= np.sqrt(np.float32(freedom / 2 - 1) / spread)  # Student's t of variance 1
        noise *= np.float32(math.sqrt(self.variance_dn2))
        return signal + noise

    def moments(
        self, mean_dn: Samples, variance_dn2: Samples, *, geometry: ImageGeometry, context: ImageContext
    ) -> Moments:
        return mean_dn, variance_dn2 + self.variance_dn2


def tail_of_mean(tail: float, photosites: float) -> float:
    """The tail of the mean of so many photosites: that of Student's t of the mean's excess kurtosis.

    >>> tail_of_mean(0.2, 1.0), round(tail_of_mean(0.2, 16.0), 9)
    (0.2, 0.05)
    """
    if photosites == 1.0:
        return tail
    capped = min(tail, _HEAVIEST_TAIL)
    excess = 6 * capped / (1 - 4 * capped) / photosites
    return excess / (6 + 4 * excess)
