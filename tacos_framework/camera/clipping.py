"""Shares of frames lost to too much light, or too little."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

_DARK = 0.02
"""A pixel none of whose channels is this far above black is nearly black [share of full scale]."""
_MOST_SATURATED, _MOST_DARK = 0.05, 0.5
"""Shares of pixels from which on somebody should be told."""


class Exposed(NamedTuple):
    """Shares of the pixels of frames."""

    saturated: float
    """With a channel at full scale [1]."""
    dark: float
    """Whose channels all lie within 2 % of full scale above the black level [1]."""

    @property
    def doubt(self) -> str:
        """Advice in a sentence; nothing where frames are well exposed."""
        said = []
        if self.saturated > _MOST_SATURATED:
            said.append(
                f"{self.saturated:.0%} of pixels are saturated: shorten exposure_ms, lower gain_db, or raise "
                "f_number; or let a control set the exposure"
            )
        if self.dark > _MOST_DARK:
            said.append(
                f"{self.dark:.0%} of pixels are nearly black: lengthen exposure_ms, raise gain_db, or lower "
                "f_number; or give more light (illumination_lux)"
            )
        return "; ".join(said)


def exposed(images_dn: NDArray[np.unsignedinteger], black_level_dn: float, white_level_dn: float) -> Exposed:
    """Shares of saturated and of nearly black pixels.

    `images_dn`: (..., C) [DN]. `black_level_dn`, `white_level_dn`: pedestal and full scale [DN].

    >>> exposed(np.uint8([[[255], [16], [100], [20]]]), 16, 255)
    Exposed(saturated=0.25, dark=0.5)
    """
    brightest = images_dn.max(axis=-1)
    dark = black_level_dn + _DARK * (white_level_dn - black_level_dn)
    return Exposed(float((brightest >= white_level_dn).mean()), float((brightest <= dark).mean()))


def mean_exposed(frames: Sequence[Exposed]) -> Exposed:
    """The means over frames of one size, of which there is at least one."""
    saturated, dark = np.mean(frames, axis=0).tolist()
    return Exposed(saturated, dark)
