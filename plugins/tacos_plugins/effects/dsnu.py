"""Photosites and columns with offsets of their own."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from tacos_framework import (
    Captures,
    Estimate,
    ImageContext,
    ImageGeometry,
    LookAlike,
    ShownBy,
    Stage,
    physical,
    setting,
)
from tacos_plugins.effects import closed_forms, observations
from tacos_plugins.effects.darks import steady_darks
from tacos_plugins.effects.fixed_pattern import PatternSettings, column_pattern, pixel_pattern
from tacos_plugins.effects.samples import Moments, Samples
from tacos_plugins.effects.shown_by import DARK, REPEATED_FLAT

_BRIGHT_COLUMN = 0.25
"""Share of a column's pixels that makes it a bright one."""


_SPECIMENS = 16
"""Sensors of which the one is taken whose bright columns are set off best: none then stands between two codes
by accident, as those of the real one do not."""


def _edge(count: int, pattern: NDArray[np.float32]) -> tuple[float, float]:
    """A positive level that so many numbers of a pattern exceed, halfway to the next, and the step there."""
    largest = np.sort(pattern, axis=None)[::-1]
    place = min(count, largest.size - 1)
    above, below = float(largest[place - 1]), float(largest[place])
    return max((above + below) / 2, 0.1), above - below


class Dsnu:
    """Dark-signal non-uniformity: ``sigma_dn p`` on each photosite, ``column_sigma_dn q`` on each column.

    The patterns p and q have mean 0 and variance 1 and belong to the sensor: they repeat in every frame, with
    the cap on too. All channels of a column share its amplifier.

    Source: EMVA 1288, release 4.0: DSNU1288 and its column component.
    """

    class Config(PatternSettings):
        sigma_dn: float = setting(
            0.0, help="Spread of the photosites' offsets.", unit="DN", averaging="photosites", ge=0, le=65535
        )
        column_sigma_dn: float = setting(
            0.0, help="Spread of the columns' offsets.", unit="DN", averaging="lines", ge=0, le=65535
        )
        sigma_e: float | None = physical(
            "sigma_dn", help="Spread of the photosites' offsets in electrons.", unit="e-", ge=0, le=1e6
        )
        column_sigma_e: float | None = physical(
            "column_sigma_dn", help="Spread of the columns' offsets in electrons.", unit="e-", ge=0, le=1e6
        )

    stage: ClassVar[Stage] = "pixel"
    rank: ClassVar[int] = 30
    neutral: ClassVar[Mapping[str, Any]] = {"sigma_dn": 0.0, "column_sigma_dn": 0.0}
    initial_guesses: ClassVar[Sequence[Mapping[str, Any]]] = ({"sigma_dn": 1.0}, {"column_sigma_dn": 0.5})
    look_alikes: ClassVar[Sequence[LookAlike]] = (
        LookAlike(
            "read-noise",
            observations.no_repeats,
            "dark",
            "two or more frames of one setting tell fixed patterns from noise",
        ),
    )
    shown_by: ClassVar[Sequence[ShownBy]] = (DARK, REPEATED_FLAT)

    def __init__(self, config: Config) -> None:
        self.config = config

    @classmethod
    def estimate_from(cls, captures: Captures) -> Iterator[Estimate]:
        """The covariance of halves of the frames of the shortest darks, beside their local mean.

        In longer ones the pattern of dark current has grown.
        """
        darks = closed_forms.whole_darks(captures)
        darks = [each for each in darks if each.context.exposure_s == darks[0].context.exposure_s]
        if found := closed_forms.pattern_variance(darks, relative=False):
            yield Estimate("sigma_dn", *closed_forms.root(found), negligible=0.05)
        if found := closed_forms.column_pattern_variance_dn2(darks):
            yield Estimate("column_sigma_dn", *closed_forms.root(found), negligible=0.03)

    @classmethod
    def guesses_from(cls, captures: Captures) -> Iterator[Mapping[str, Any]]:
        """Spreads at which as many columns, and photosites, are bright as in a dark that is cut off at 0."""
        for dark in steady_darks(captures)[-1:]:
            if not dark.is_cut_off:
                continue
            geometry, channels = dark.capture.geometry, dark.above_dn.shape[-1]
            columns = int(np.count_nonzero(dark.bright.mean(axis=(0, 2)) > _BRIGHT_COLUMN))
            if columns:
                patterns = [column_pattern("dsnu-columns", seed, geometry) for seed in range(_SPECIMENS)]
                edges = [_edge(columns, pattern) for pattern in patterns]
                seed = int(np.argmax([width / level for level, width in edges]))
                yield {"column_sigma_dn": dark.lowest_dn / edges[seed][0], "map_seed": seed}
            if dark.hot_dn.size:
                pattern = pixel_pattern("dsnu", PatternSettings(), geometry, channels)
                yield {"sigma_dn": dark.lowest_dn / _edge(dark.hot_dn.size, pattern)[0]}

    def on_array(
        self, signal: Samples, *, geometry: ImageGeometry, context: ImageContext, rng: np.random.Generator
    ) -> Samples:
        if self.config.sigma_dn == 0 and self.config.column_sigma_dn == 0:
            return signal
        return signal + self._offset(geometry, signal.shape[-1]).astype(signal.dtype, copy=False)

    def moments(
        self, mean_dn: Samples, variance_dn2: Samples, *, geometry: ImageGeometry, context: ImageContext
    ) -> Moments:
        """Means with the pattern; temporal variance is not touched."""
        if self.config.sigma_dn == 0 and self.config.column_sigma_dn == 0:
            return mean_dn, variance_dn2
        return mean_dn + self._offset(geometry, mean_dn.shape[-1]), variance_dn2

    def _offset(self, geometry: ImageGeometry, channels: int) -> NDArray[np.float32]:
        """(H, W, C) offsets, zero on average [DN]."""
        offset = np.zeros((geometry.height_px, geometry.width_px, channels), np.float32)
        if self.config.sigma_dn:
            pixels = pixel_pattern("dsnu", self.config, geometry, channels)
            offset += np.float32(self.config.sigma_dn) * pixels
        if self.config.column_sigma_dn:
            columns = column_pattern("dsnu-columns", self.config.map_seed, geometry)
            offset += np.float32(self.config.column_sigma_dn) * columns
        return offset
