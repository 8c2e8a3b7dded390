"""A converter with fewer codes than the file has."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from tacos_framework.contracts import Stage
from tacos_framework.settings import Settings, physical, setting
from tacos_framework.values import ImageContext, ImageGeometry
from tacos_plugins.effects.pointwise import Moments


class Quantisation:
    """Rounds samples to multiples of `step_dn`, to the nearest or downwards.

    A 10-bit converter in a 12-bit file has a step of 4 DN and leaves a comb of empty codes. Rounding
    downwards darkens the image by half a step. Nothing happens at a step of 1 DN or less to the nearest:
    so the file is rounded anyway. The photosites of a binned pixel are rounded one by one, and noise makes
    their errors independent: the average has steps as many times finer as the binning, and the same shift.

    References
    ----------
    Widrow & Kollar 2008, "Quantization noise": uniform error of variance step^2 / 12.
    """

    class Config(Settings):
        """Settings of the effect."""

        step_dn: float = setting(1.0, help="Distance from code to code.", unit="DN", gt=0, le=65535)
        step_share: float | None = physical(
            "step_dn",
            help="The same over the range of the file's codes: 1/1024 is a converter of 10 bits.",
            unit="of full scale",
            gt=0,
            le=1,
        )
        rounding: Literal["nearest", "floor"] = setting("nearest", help="Where values between two codes go.")

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

    def on_array(
        self,
        signal: NDArray[np.floating],
        *,
        geometry: ImageGeometry,
        context: ImageContext,
        rng: np.random.Generator,
    ) -> NDArray[np.floating]:
        """The samples, rounded."""
        step = self.config.step_dn / geometry.binning
        if self.config.rounding == "floor":
            return np.floor(signal / step) * step - (self.config.step_dn - step) / 2
        return np.rint(signal / step) * step if step > 1 else signal

    def moments(
        self,
        mean_dn: NDArray[np.floating],
        variance_dn2: NDArray[np.floating],
        *,
        geometry: ImageGeometry,
        context: ImageContext,
    ) -> Moments:
        """Moments in excess of the file's own rounding, which adds 1/12 DN^2."""
        step = self.config.step_dn / geometry.binning
        shift = self.config.step_dn / 2 if self.config.rounding == "floor" else 0.0
        return mean_dn - shift, variance_dn2 + max(step**2 - 1, 0.0) / 12
