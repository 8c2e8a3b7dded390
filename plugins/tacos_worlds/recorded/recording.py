"""A folder of frames that one camera took at several exposures."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_worlds.recorded.response import Response

_TOP = 0.96
"""Share of the largest code from which on samples count as clipped: a colour may fill its photosites below
the largest code, and noise spreads it there."""
_MOSAIC = 1.03
"""Ratio of brightnesses under different colour filters, at least."""


@dataclass(frozen=True, eq=False)
class ExposedFrames:
    """Frames of one exposure, in the order they were taken."""

    exposure_ms: float
    stamp_s: NDArray[np.float64]  # (N,) times of ``times.csv``, from the first of the recording [s]
    codes_dn: NDArray[np.uint16]  # (N, H, W) samples as stored [DN]

    @property
    def name(self) -> str:
        """The exposure as text, such as ``8`` or ``0.5``."""
        return f"{self.exposure_ms:g}"


@dataclass(frozen=True, eq=False)
class Recording:
    """Exposures of one walk of one camera."""

    exposures: Mapping[str, ExposedFrames]  # by name, the shortest first
    bits: int  # bits of a sample, of which its largest code tells
    response: Response  # from codes to light
    response_from: str  # where the response comes from, in a sentence
    green_on_diagonal: bool = False  # true if the mosaic has green at (0, 0) and (1, 1)

    @property
    def white_dn(self) -> int:
        """Largest code [DN]."""
        return (1 << self.bits) - 1

    @property
    def has_mosaic(self) -> bool:
        """True if samples of different places in each 2 x 2 differ in brightness, as under colour filters."""
        brightest = max(self.exposures, key=lambda name: self.exposures[name].exposure_ms)
        codes = self.exposures[brightest].codes_dn
        means = [float(codes[:, row::2, column::2].mean()) for row in (0, 1) for column in (0, 1)]
        return max(means) > _MOSAIC * max(min(means), 1e-6)

    @property
    def top_dn(self) -> float:
        """Light from which on samples are clipped [DN]."""
        return float(np.interp(_TOP * self.white_dn, self.response.code_dn, self.response.light_dn))

    def light(self, name: str) -> NDArray[np.float32]:
        """(N, H, W) light of an exposure's frames, linear, in 0..`white_dn` [DN]."""
        return self.response.light(self.exposures[name].codes_dn)


def green_on_diagonal(codes_dn: NDArray[np.uint16]) -> bool:
    """True if the samples at (0, 0) and (1, 1) of each 2 x 2 are more alike than the other two.

    `codes_dn`: (N, H, W) of a Bayer mosaic [DN].
    """
    planes = {
        (row, column): codes_dn[:, row::2, column::2].astype(np.float32)
        for row in (0, 1)
        for column in (0, 1)
    }
    unlike = [
        float(np.mean(np.abs(planes[first] - planes[second])))
        for first, second in (((0, 0), (1, 1)), ((0, 1), (1, 0)))
    ]
    return unlike[0] < unlike[1]
