"""Rows and columns that jump from frame to frame."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, ClassVar

import numpy as np

from tacos_framework import (
    Captures,
    Estimate,
    ImageContext,
    ImageGeometry,
    Settings,
    ShownBy,
    Stage,
    physical,
    setting,
)
from tacos_plugins.effects import closed_forms
from tacos_plugins.effects.samples import Moments, Samples
from tacos_plugins.effects.shown_by import DARK


class RowNoise:
    """Adds an offset to each row and each column of each frame, new in every frame.

    All channels of a row share its offset, as they share its read-out. The offsets do not depend on the
    light: they are there with the cap on, where flicker is not.

    Source: EMVA 1288, release 4.0: temporal row and column variance.
    """

    class Config(Settings):
        sigma_dn: float = setting(
            0.0, help="Standard deviation of the rows' offsets.", unit="DN", averaging="lines", ge=0, le=65535
        )
        column_sigma_dn: float = setting(
            0.0,
            help="Standard deviation of the columns' offsets.",
            unit="DN",
            averaging="lines",
            ge=0,
            le=65535,
        )
        sigma_e: float | None = physical(
            "sigma_dn", help="That of the rows in electrons.", unit="e-", ge=0, le=1e6
        )
        column_sigma_e: float | None = physical(
            "column_sigma_dn", help="That of the columns in electrons.", unit="e-", ge=0, le=1e6
        )

    stage: ClassVar[Stage] = "readout"
    rank: ClassVar[int] = 30
    neutral: ClassVar[Mapping[str, Any]] = {"sigma_dn": 0.0, "column_sigma_dn": 0.0}
    initial_guesses: ClassVar[Sequence[Mapping[str, Any]]] = ({"sigma_dn": 0.5}, {"column_sigma_dn": 0.5})
    shown_by: ClassVar[Sequence[ShownBy]] = (DARK,)

    def __init__(self, config: Config) -> None:
        self.config = config

    @classmethod
    def estimate_from(cls, captures: Captures) -> Iterator[Estimate]:
        """Variance that rows and columns of darks share within a frame, beyond that of independent pixels."""
        for name, axis in (("sigma_dn", 1), ("column_sigma_dn", 0)):
            if found := closed_forms.line_variance_dn2(captures, axis):
                yield Estimate(name, *closed_forms.root(found), negligible=0.05)

    def on_array(
        self, signal: Samples, *, geometry: ImageGeometry, context: ImageContext, rng: np.random.Generator
    ) -> Samples:
        if self.config.sigma_dn == 0 and self.config.column_sigma_dn == 0:
            return signal
        frames, height, width, _ = signal.shape
        rows = rng.standard_normal((frames, height, 1, 1), np.float32)
        columns = rng.standard_normal((frames, 1, width, 1), np.float32)
        rows *= np.float32(self.config.sigma_dn)
        columns *= np.float32(self.config.column_sigma_dn)
        return signal + (rows + columns)

    def moments(
        self, mean_dn: Samples, variance_dn2: Samples, *, geometry: ImageGeometry, context: ImageContext
    ) -> Moments:
        """Variances of a sample with those of the offsets."""
        return mean_dn, variance_dn2 + self.config.sigma_dn**2 + self.config.column_sigma_dn**2
