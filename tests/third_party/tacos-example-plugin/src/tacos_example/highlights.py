"""Exposure control that spares the highlights."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from tacos_framework import Exposure, ImageContext, Settings, setting


class Highlights:
    """Keeps the brightest pixels just below full scale, whatever that leaves of the shadows.

    Photographers call it exposing to the right. Where too many pixels are full, there is no telling by how
    much: the exposure is halved.
    """

    class Config(Settings):
        percentile: float = setting(
            99.0, help="Share of pixels that must not be full.", unit="%", gt=0, le=100
        )
        level: float = setting(0.8, help="Where that percentile is to be, over full scale.", gt=0, lt=1)
        longest_ms: float = setting(30.0, help="Greatest exposure time.", unit="ms", gt=0)

    def __init__(self, config: Config) -> None:
        self.config = config

    def adjust(
        self, frame_dn: NDArray[np.unsignedinteger], *, exposure: Exposure, context: ImageContext
    ) -> Exposure:
        """The exposure of the next frame: another time, the same gain."""
        span_dn = context.white_level_dn - context.black_level_dn
        bright = (np.percentile(frame_dn, self.config.percentile) - context.black_level_dn) / span_dn
        factor = 0.5 if bright >= 1 else min(self.config.level / max(bright, 1e-3), 4.0)
        time_s = min(max(exposure.time_s * factor, 1e-5), self.config.longest_ms * 1e-3)
        return Exposure(time_s, exposure.f_number, exposure.gain_db)
