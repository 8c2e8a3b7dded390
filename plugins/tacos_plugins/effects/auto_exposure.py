"""A camera that sets its exposure by what it sees."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray
from pydantic import model_validator

from tacos_framework import Captures, ImageContext, ImageGeometry, Settings, ShownBy, Stage, setting
from tacos_framework.camera import exposure_per_luminance, luminance
from tacos_plugins.effects.samples import Samples
from tacos_plugins.effects.settling import LEAST_CHANGE, means_dn, sequences, settling, settling_of
from tacos_plugins.effects.shown_by import SEQUENCE


class AutoExposure:
    """Exposes longer or shorter, so that the mean focal-plane exposure comes to `target_mlx_s`.

    Every camera meters the mean luminance of its own frames, of the scenario's exposure, and takes it to the
    target as far as the limits allow. With a lag it follows exponentially, in stops, from frame to frame of
    an episode; at the first it is settled. The light is scaled ahead of the noise, so the noise is that of
    the other exposure time; motion blur stays as it is, and so does the gain.

    Without a target it is metered against the first frame of the episode: `strength` is the share of a
    change, in stops, that is evened out. That needs no absolute level, so a diagnosis can find it in
    sequences. `first` is for a camera that has not settled as the episode begins.

    A white wall (reflectance 0.8) at 20 lux, f/2 and 30 ms gives 30 mlx s; half of it is one stop less:

    >>> effect = AutoExposure(AutoExposure.Config(target_mlx_s=15.0))
    >>> wall = np.full((1, 4, 4, 1), 0.8 * 20 / math.pi)
    >>> context = ImageContext(exposure_s=0.030, f_number=2.0)
    >>> effect.factors(wall, context).round(6).tolist()
    [0.5]
    """

    class Config(Settings):
        target_mlx_s: float | None = setting(
            None,
            help="Mean focal-plane exposure to aim for; without it `strength` counts. A white wall fills an "
            "8-bit image of the default sensor to 200 of 255 at 30.",
            unit="mlx s",
            gt=0,
            le=1e6,
        )
        strength: float = setting(
            0.0,
            help="Without a target: share of a change since the first frame that is evened out, in stops.",
            ge=0,
            le=1,
        )
        first: float = setting(
            1.0, help="Exposure of the first frame, over the one it settles at.", gt=0, le=1e3
        )
        shortest: float = setting(
            1 / 64, help="Least exposure, over the scenario's exposure time.", gt=0, le=1e6
        )
        longest: float = setting(
            4.0, help="Greatest exposure, over the scenario's exposure time.", gt=0, le=1e6
        )
        lag_frames: float = setting(
            0.0,
            help="Frames after which 63 % of a change is followed; at once if 0.",
            unit="frame",
            ge=0,
            le=1e4,
        )

        @model_validator(mode="after")
        def _limits_rise(self) -> AutoExposure.Config:
            if self.shortest > self.longest:
                raise ValueError(f"shortest is {self.shortest}, above longest, {self.longest}")
            return self

    stage: ClassVar[Stage] = "exposure"
    rank: ClassVar[int] = 40
    neutral: ClassVar[Mapping[str, Any]] = {
        "target_mlx_s": None,
        "strength": 0.0,
        "first": 1.0,
        "lag_frames": 0.0,
    }
    initial_guesses: ClassVar[Sequence[Mapping[str, Any]]] = ()
    shown_by: ClassVar[Sequence[ShownBy]] = (SEQUENCE,)

    def __init__(self, config: Config) -> None:
        self.config = config

    @staticmethod
    def guesses_from(captures: Captures) -> Iterator[Mapping[str, Any]]:
        """Guesses where the level of a sequence drifts against what is expected."""
        for capture in sequences(captures):
            real, expected = (means.mean(axis=1) for means in means_dn(capture))
            drift, change = (np.log(means / means[0]) for means in (real / expected, expected))
            if np.ptp(drift) <= LEAST_CHANGE:
                continue
            if np.ptp(change) > LEAST_CHANGE:
                slope = -float(drift @ change) / float(change @ change)
                yield {"strength": min(max(slope, 0.05), 1.0)}
            first, lag_frames = settling_of(real / expected)
            yield {"first": first, "lag_frames": lag_frames}

    def on_array(
        self, signal: Samples, *, geometry: ImageGeometry, context: ImageContext, rng: np.random.Generator
    ) -> Samples:
        """Light, exposed by its metering; a target needs it in cd/m2, and the context's f-number."""
        config = self.config
        if config.target_mlx_s is None and config.strength == 0 and config.first == 1:
            return signal
        return signal * self.factors(signal, context).astype(signal.dtype)[:, None, None, None]

    def factors(self, light_cd_m2: NDArray[np.floating], context: ImageContext) -> NDArray[np.float64]:
        """(N,) what the exposure of each frame is multiplied by; goes on from the frame before [1]."""
        mean = light_cd_m2.mean(axis=(1, 2), dtype=np.float64)
        brightness = np.maximum(luminance(mean) if mean.shape[-1] == 3 else mean[:, 0], 1e-12)
        limited = np.clip(self._wanted(brightness, context), self.config.shortest, self.config.longest)
        followed = followed_from(context.memory.get("factor"), limited, self.config.lag_frames)
        context.memory["factor"] = float(followed[-1])
        start = int(context.memory.get("frames", 0))
        context.memory["frames"] = start + len(followed)
        return followed * settling(self.config.first, self.config.lag_frames, start, len(followed))

    def _wanted(self, brightness: NDArray[np.float64], context: ImageContext) -> NDArray[np.float64]:
        """(N,) factors that metering asks for [1]."""
        if self.config.target_mlx_s is None:
            reference = context.memory.setdefault("brightness", float(brightness[0]))
            return np.asarray((reference / brightness) ** self.config.strength)
        f_number = context.known_f_number("effect.auto-exposure")
        exposure_mlx_s = 1e3 * brightness * exposure_per_luminance(context.exposure_s, f_number)
        return np.asarray(self.config.target_mlx_s / np.maximum(exposure_mlx_s, 1e-12))


def followed_from(
    before: float | None, wanted: NDArray[np.float64], lag_frames: float
) -> NDArray[np.float64]:
    """Factors that follow wanted ones with a lag, exponentially in stops.

    - `before`: that of the frame before; None at the first of an episode, which is settled [1].
    - `wanted`: (N,) factors, above 0 [1].
    - `lag_frames`: frames after which a step is followed to 63 % [frame].

    Returns: (N,) float64 [1].

    >>> lag_frames = 1 / math.log(2)
    >>> followed_from(None, np.array([1.0, 4.0, 4.0]), lag_frames).round(3).tolist()
    [1.0, 2.0, 2.828]
    >>> followed_from(2.0, np.array([4.0]), lag_frames).round(3).tolist()
    [2.828]
    """
    if lag_frames == 0.0:
        return wanted
    share = 1 - math.exp(-1 / lag_frames)
    stops = np.log2(wanted)
    at = stops[0] if before is None else math.log2(before)
    for i in range(len(stops)):
        at += share * (stops[i] - at)
        stops[i] = at
    return np.exp2(stops)
