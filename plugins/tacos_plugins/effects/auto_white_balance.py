"""A camera whose automatic white balance is still settling as a sequence begins."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, ClassVar

import numpy as np

from tacos_framework import (
    Captures,
    ContextMissing,
    ImageContext,
    ImageGeometry,
    Settings,
    ShownBy,
    Stage,
    setting,
)
from tacos_plugins.effects.samples import Samples
from tacos_plugins.effects.settling import LEAST_CHANGE, means_dn, sequences, settling, settling_of
from tacos_plugins.effects.shown_by import SEQUENCE


class AutoWhiteBalance:
    """Multiplies red and blue by gains that come to 1 from frame to frame of an episode.

    What is settled is `effect.white-balance`'s; here is the way there, exponential in stops, as controls
    that follow the last frame with a lag go it.
    """

    class Config(Settings):
        red_first: float = setting(
            1.0, help="Gain of red in the first frame, over the settled.", gt=0, le=100
        )
        blue_first: float = setting(1.0, help="The same of blue.", gt=0, le=100)
        lag_frames: float = setting(
            0.0,
            help="Frames after which 63 % of the way is gone; only the first frame differs if 0.",
            unit="frame",
            ge=0,
            le=1e4,
        )

    stage: ClassVar[Stage] = "isp"
    rank: ClassVar[int] = 21
    of_colours: ClassVar[bool] = True
    neutral: ClassVar[Mapping[str, Any]] = {"red_first": 1.0, "blue_first": 1.0, "lag_frames": 0.0}
    initial_guesses: ClassVar[Sequence[Mapping[str, Any]]] = ()
    shown_by: ClassVar[Sequence[ShownBy]] = (SEQUENCE,)

    def __init__(self, config: Config) -> None:
        self.config = config

    @staticmethod
    def guesses_from(captures: Captures) -> Iterator[Mapping[str, Any]]:
        """Guesses where red or blue of a sequence in colour drifts against green."""
        for capture in sequences(captures):
            if capture.real_dn.shape[-1] != 3:
                continue
            real, expected = means_dn(capture)
            ratio = (real / real[:, 1:2]) / (expected / expected[:, 1:2])
            if np.ptp(np.log(ratio), axis=0).max() <= LEAST_CHANGE:
                continue
            (red, red_lag), (blue, blue_lag) = (settling_of(ratio[:, channel]) for channel in (0, 2))
            clearer = red_lag if abs(np.log(red)) > abs(np.log(blue)) else blue_lag
            yield {"red_first": red, "blue_first": blue, "lag_frames": clearer}

    def on_array(
        self, signal: Samples, *, geometry: ImageGeometry, context: ImageContext, rng: np.random.Generator
    ) -> Samples:
        """The samples with the gains of their frames; goes on from the frame before."""
        config = self.config
        if config.red_first == 1 and config.blue_first == 1:
            return signal
        if signal.shape[-1] != 3:
            raise ContextMissing("effect.auto-white-balance needs images in colour")
        start = int(context.memory.get("frames", 0))
        context.memory["frames"] = start + len(signal)
        gains = np.ones((len(signal), 1, 1, 3))
        for channel, first in ((0, config.red_first), (2, config.blue_first)):
            gains[:, 0, 0, channel] = settling(first, config.lag_frames, start, len(signal))
        return (signal - context.black_level_dn) * gains.astype(signal.dtype) + context.black_level_dn
