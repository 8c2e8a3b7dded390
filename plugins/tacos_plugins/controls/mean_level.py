"""Exposure control by the mean level of the image."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Exposure, ImageContext, setting
from tacos_plugins.controls.limits import ExposureLimits, signal_shares

DARKEST = 1e-3
"""Mean level that a black frame is taken for, so that the next is no more than ten stops brighter [1]."""


class MeanLevel:
    """Drives the mean level of the image to a target: what most cameras do.

    The mean of a frame, as a share of full scale, says by how many stops the next is to be brighter. Of
    these it goes a part, so that a change of light is followed exponentially, to 63 % after `lag_frames`.
    What is asked of the camera is given as exposure time first, and as gain where the time is at its limit.
    A frame that is full tells less than the truth, so coming into bright light takes longer.

    >>> control = MeanLevel(MeanLevel.Config(target=0.2, lag_frames=0))
    >>> frame = np.full((4, 4, 1), 102, np.uint8)  # 0.4 of full scale, one stop too bright
    >>> round(control.adjust(frame, exposure=Exposure(0.010), context=ImageContext()).time_s, 6)
    0.005
    """

    class Config(ExposureLimits):
        target: float = setting(0.2, help="Mean level to aim for, as a share of full scale.", gt=0, lt=1)
        lag_frames: float = setting(
            2.0,
            help="Frames after which 63 % of a change is followed; at once if 0.",
            unit="frame",
            ge=0,
            le=1e4,
        )

    def __init__(self, config: Config) -> None:
        self.config = config

    @property
    def warm_up_frames(self) -> int:
        return self.config.warm_up_frames

    def adjust(
        self, frame_dn: NDArray[np.unsignedinteger], *, exposure: Exposure, context: ImageContext
    ) -> Exposure:
        config = self.config
        level = max(float(signal_shares(frame_dn, context).mean()), DARKEST)
        share = 1.0 if config.lag_frames == 0 else 1 - math.exp(-1 / config.lag_frames)
        wanted = (config.target / level) ** share  # part of the way, in stops
        return config.exposure(exposure.time_s * exposure.gain * wanted, exposure.f_number)
