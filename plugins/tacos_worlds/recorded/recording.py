"""A folder of frames that one camera took at several exposures."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tacos_worlds.recorded.response import Response
from tacos_worlds.recorded.saturation import trusted_codes

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
    clipping_codes: NDArray[np.int64]
    """(2, 2) codes from which samples are clipped, as `saturation` finds them."""
    told_response: Response | None = None
    """The response that was told, where the exposures contradict it in part; then `response` is mended."""
    green_on_diagonal: bool = False  # true if the mosaic has green at (0, 0) and (1, 1)

    @property
    def white_dn(self) -> int:
        """Largest code [DN]."""
        return (1 << self.bits) - 1

    @cached_property
    def mosaic(self) -> str:
        """``RG`` or ``GR`` where samples of different places in each 2 x 2 differ in brightness, as under
        colour filters, else ``none``; red and blue cannot be told apart."""
        codes = max(self.exposures.values(), key=lambda each: each.exposure_ms).codes_dn
        means = [float(codes[:, row::2, column::2].mean()) for row in (0, 1) for column in (0, 1)]
        if max(means) <= _MOSAIC * max(min(means), 1e-6):
            return "none"
        return "GR" if self.green_on_diagonal else "RG"

    @cached_property
    def _top_codes(self) -> NDArray[np.int64]:
        frames = {each.exposure_ms: each.codes_dn for each in self.exposures.values()}
        return trusted_codes(frames, self.told_response or self.response, self.clipping_codes)

    @property
    def clipping_dn(self) -> float:
        """Light from which on samples of a colour are clipped, the least of all colours [DN]."""
        return self._light_of(self.clipping_codes.min())

    @property
    def top_dn(self) -> float:
        """Light from which on samples of a colour tell nothing, the least of all colours [DN]."""
        return self._light_of(self._top_codes.min())

    def _light_of(self, code_dn: int) -> float:
        return float(np.interp(code_dn, self.response.code_dn, self.response.light_dn))

    def clipped(self, name: str) -> float:
        """Share of samples of an exposure that are clipped, or beyond what exposures agree on [1]."""
        codes = self.exposures[name].codes_dn
        return float(
            np.mean([np.mean(codes[:, r::2, c::2] >= self._top_codes[r, c]) for r, c in np.ndindex(2, 2)])
        )

    def cut_off(self, name: str) -> float:
        """Share of samples of an exposure at code 0, where darker light would be as well [1]."""
        return float(np.mean(self.exposures[name].codes_dn == 0))

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
