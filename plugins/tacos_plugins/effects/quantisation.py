"""A converter with fewer codes than the file has."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, ClassVar, Literal

import numpy as np

from tacos_framework import (
    Captures,
    Estimate,
    ImageContext,
    ImageGeometry,
    Settings,
    Stage,
    physical,
    setting,
)
from tacos_plugins.effects.code_steps import code_step_dn
from tacos_plugins.effects.samples import Moments, Samples


class Quantisation:
    """Rounds samples to multiples of `step_dn`, to the nearest or downwards.

    A 10-bit converter in a 12-bit file has a step of 4 DN and leaves a comb of empty codes. Rounding
    downwards darkens the image by half a step, and the last code lies a step below the end of the range: six
    bits shifted up by two stop at 252. Nothing happens at a step of 1 DN or less to the nearest:
    so the file is rounded anyway. The photosites of a binned pixel are rounded one by one, and noise makes
    their errors independent: of the average of n the error has 1 / n of the variance, and the shift stays.

    Source: Widrow & Kollar 2008, "Quantization noise": uniform error of variance step^2 / 12.
    """

    class Config(Settings):
        step_dn: float = setting(1.0, help="Distance from code to code.", unit="DN", gt=0, le=65535)
        step_share: float | None = physical(
            "step_dn",
            help="The same over the range of the file's codes: 1/1024 is a converter of 10 bits.",
            unit="of full scale",
            gt=0,
            le=1,
        )
        rounding: Literal["nearest", "floor"] = setting("nearest", help="Code of a value between two codes.")

    stage: ClassVar[Stage] = "readout"
    rank: ClassVar[int] = 50
    neutral: ClassVar[Mapping[str, Any]] = {"step_dn": 1.0, "rounding": "nearest"}
    initial_guesses: ClassVar[Sequence[Mapping[str, Any]]] = (
        {"rounding": "floor"},
        {"step_dn": 2},
        {"step_dn": 3},
        {"step_dn": 4},
        {"step_dn": 5},
        {"step_dn": 8},
        {"step_dn": 16},
    )

    def __init__(self, config: Config) -> None:
        self.config = config

    @classmethod
    def guesses_from(cls, captures: Captures) -> Iterator[Mapping[str, Any]]:
        """Distance of the codes that the files use, to the nearest or downwards."""
        if found := code_step_dn(captures):
            yield {"step_dn": found.value}
            yield {"step_dn": found.value, "rounding": "floor"}

    @classmethod
    def estimate_from(cls, captures: Captures) -> Iterator[Estimate]:
        """The same; nothing where all codes are used, since rounding downwards leaves none empty."""
        if found := code_step_dn(captures):
            yield Estimate("step_dn", *found, negligible=0.5)

    def on_array(
        self, signal: Samples, *, geometry: ImageGeometry, context: ImageContext, rng: np.random.Generator
    ) -> Samples:
        step = self.config.step_dn
        down = self.config.rounding == "floor"
        if step <= 1 and not down:
            return signal
        if geometry.binning == 1.0:
            if down:
                return np.floor(np.minimum(signal, context.white_level_dn + 0.5) / step) * step
            return np.rint(signal / step) * step
        photosites = geometry.binning**2
        coarse = max(step / photosites, 1.0)  # codes an average of whole steps can have, if not every one
        left = excess_dn2(step, photosites) - (coarse**2 - 1) / 12
        noise = rng.standard_normal(signal.shape, np.float32) * np.float32(math.sqrt(left))
        mean = signal + noise - (step / 2 if down else 0.0)
        return np.rint(mean / coarse) * coarse if coarse > 1 else mean

    def moments(
        self, mean_dn: Samples, variance_dn2: Samples, *, geometry: ImageGeometry, context: ImageContext
    ) -> Moments:
        """Moments in excess of the file's own rounding, which adds 1/12 DN^2."""
        step = self.config.step_dn
        shift = step / 2 if self.config.rounding == "floor" else 0.0
        return mean_dn - shift, variance_dn2 + excess_dn2(step, geometry.binning**2)


def excess_dn2(step_dn: float, photosites: float) -> float:
    """Variance of the rounding of an average beyond that of whole digital numbers [DN^2].

    >>> excess_dn2(4.0, 1.0), excess_dn2(4.0, 4.0)
    (1.25, 0.3125)
    """
    return max(step_dn**2 - 1, 0.0) / 12 / photosites
