"""Between which exposures a camera may choose: longer first, then more gain."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from pydantic import model_validator

from tacos_framework import Exposure, ImageContext, Settings, setting
from tacos_framework.camera import luminance


class ExposureLimits(Settings):
    """Settings that all exposure controls share."""

    shortest_ms: float = setting(0.05, help="Least exposure time.", unit="ms", gt=0, le=1e4)
    longest_ms: float = setting(
        20.0,
        help="Greatest exposure time; where it is not enough, gain is added. Longer ones blur motion.",
        unit="ms",
        gt=0,
        le=1e4,
    )
    lowest_gain_db: float = setting(0.0, help="Least gain.", unit="dB", ge=-60, le=120)
    highest_gain_db: float = setting(
        24.0, help="Greatest gain, and with it noise.", unit="dB", ge=-60, le=120
    )
    warm_up_frames: int = setting(
        20, help="Frames taken of the first view of a walk before the first that counts.", ge=0, le=1000
    )

    @model_validator(mode="after")
    def _limits_rise(self) -> ExposureLimits:
        if self.shortest_ms > self.longest_ms:
            raise ValueError(f"shortest_ms is {self.shortest_ms}, above longest_ms, {self.longest_ms}")
        if self.lowest_gain_db > self.highest_gain_db:
            raise ValueError(
                f"lowest_gain_db is {self.lowest_gain_db}, above highest_gain_db, {self.highest_gain_db}"
            )
        return self

    def exposure(self, signal_s: float, f_number: float) -> Exposure:
        """The exposure within the limits that comes nearest to a signal, with the least gain.

        `signal_s`: exposure time times gain as a factor [s]. `f_number`: of the lens [1].

        >>> limits = ExposureLimits(longest_ms=10, highest_gain_db=20)
        >>> chosen = [limits.exposure(signal_s, f_number=2.0) for signal_s in (0.005, 0.02, 9)]
        >>> [(each.time_s, round(each.gain_db, 1)) for each in chosen]
        [(0.005, 0.0), (0.01, 6.0), (0.01, 20.0)]
        """
        lowest = 10 ** (self.lowest_gain_db / 20)
        time_s = min(max(signal_s / lowest, self.shortest_ms * 1e-3), self.longest_ms * 1e-3)
        gain_db = 20 * math.log10(signal_s / time_s)
        return Exposure(time_s, f_number, min(max(gain_db, self.lowest_gain_db), self.highest_gain_db))


def signal_shares(frame_dn: NDArray[np.unsignedinteger], context: ImageContext) -> NDArray[np.float32]:
    """(H, W) luminance of a linear frame over full scale, 0 at the pedestal [1].

    >>> signal_shares(np.full((1, 1, 3), 255, np.uint8), ImageContext()).tolist()
    [[1.0]]
    """
    grey = luminance(frame_dn) if frame_dn.shape[-1] == 3 else frame_dn[..., 0]
    span = context.white_level_dn - context.black_level_dn
    shares = (np.asarray(grey, np.float32) - np.float32(context.black_level_dn)) / np.float32(span)
    return np.clip(shares, 0, 1)
