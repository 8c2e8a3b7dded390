"""The light that a recording holds, frame by frame, as its own camera saw it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tacos_worlds.recorded.noise import LinearNoise, measured_noise
from tacos_worlds.recorded.recording import ExposedFrames, Recording

if TYPE_CHECKING:
    from tacos_worlds.recorded.motion import Motion, Steps

Light = NDArray[np.float32]

REFLECTED = 0.18
"""Share of the light on a scene that it sends back, as light meters have it (ISO 2720)."""


@dataclass(frozen=True, eq=False)
class Source:
    """Light of a recording per millisecond of exposure, in its own unit [DN/ms]."""

    recording: Recording
    mosaic: int
    """Period of its colour filters [px]: 2 for Bayer, each cell a pixel of three colours, 1 for none."""
    red_first: bool = True  # true if the first sample that is not green is red
    black_dn: float = 0.0  # pedestal in the linear samples [DN]
    fall_off: NDArray[np.float32] | None = None
    """(H, W) share of the light that the lens passes, 1 on its axis."""

    @property
    def channels(self) -> int:
        """3 where it has colours."""
        return 3 if self.mosaic == 2 else 1

    @cached_property
    def _lights(self) -> dict[str, Light]:
        recording = self.recording
        return {name: recording.light(name) - np.float32(self.black_dn) for name in recording.exposures}

    def samples(self, name: str, index: int) -> Light:
        """(H, W) linear samples of a frame, as its photosites lie [DN]."""
        return self._lights[name][index]

    @property
    def greens(self) -> tuple[tuple[int, int], ...]:
        """(row, column) of the green samples of a cell; of the only one where there is no mosaic."""
        if self.mosaic == 1:
            return ((0, 0),)
        return ((0, 0), (1, 1)) if self.recording.green_on_diagonal else ((0, 1), (1, 0))

    @cached_property
    def size_px(self) -> tuple[int, int]:
        """(height, width) of its light [px]."""
        height, width = next(iter(self.recording.exposures.values())).codes_dn.shape[1:]
        return height // self.mosaic, width // self.mosaic

    @lru_cache(maxsize=16)  # noqa: B019 - a source lives as long as its process
    def noise(self, name: str) -> LinearNoise:
        return measured_noise([self._lights[name]], mosaic=self.mosaic, top_dn=self.top_dn)

    @cached_property
    def mean(self) -> float:
        """Mean of its light [DN/ms]: the median over exposures that are neither dark nor full."""
        return float(
            np.median([self._lights[n].mean() / e.exposure_ms for n, e in self.recording.exposures.items()])
        )

    @cached_property
    def balance(self) -> NDArray[np.float32]:
        """(C,) factors that make the mean of each colour that of green."""
        if self.channels == 1:
            return np.ones(1, np.float32)
        brightest = max(
            self.recording.exposures.values(), key=lambda e: self.clipped(e.name) < 0.01 and e.exposure_ms
        )
        means = self._cells(self._lights[brightest.name].mean(0)).mean((0, 1))
        return np.asarray(means[1] / np.maximum(means, 1e-6), np.float32)

    @lru_cache(maxsize=16)  # noqa: B019
    def clipped(self, name: str) -> float:
        """Share of samples of an exposure that are clipped [1]."""
        return self.recording.clipped(name)

    @property
    def top_dn(self) -> float:
        """Light beyond which an exposure tells nothing [DN]."""
        return self.recording.top_dn - self.black_dn

    def exposure_for(self, exposure_ms: float) -> ExposedFrames:
        """The frames that show a candidate's exposure: the longest that is no longer, else the shortest."""
        fitting = [e for e in self.recording.exposures.values() if e.exposure_ms <= exposure_ms * 1.001]
        if not fitting:
            return next(iter(self.recording.exposures.values()))
        unclipped = [e for e in fitting if self.clipped(e.name) < 0.01]
        return (unclipped or fitting[:1])[-1]

    def light(self, name: str, index: int, exposure_ms: float) -> Light:
        """(H, W, C) light of a frame over an exposure no shorter than its own [DN/ms]."""
        frames = self.recording.exposures[name]
        samples = self._lights[name][index]
        if exposure_ms > frames.exposure_ms * 1.01 and (motion := self.motion) is not None:
            from tacos_worlds.recorded.motion import blurred

            samples = blurred(
                samples,
                motion[0],
                middle_s=self.middle_s(name, index),
                own_ms=frames.exposure_ms,
                wanted_ms=exposure_ms,
                mosaic=self.mosaic,
            )
        light = self._cells(samples) * (self.balance / np.float32(frames.exposure_ms))
        return light if self.fall_off is None else np.asarray(light / self.fall_off[..., None], np.float32)

    def variance(self, name: str, light: Light) -> Light:
        """Of the noise in light of one frame [(DN/ms)^2]. `light`: (H, W, C) [DN/ms]."""
        passed = 1.0 if self.fall_off is None else self.fall_off[..., None]
        return self._variance(name, light, passed)

    def variance_of_levels(self, name: str, light: Light) -> Light:
        """The same on the axis of the lens, of (..., C) light [(DN/ms)^2]."""
        return self._variance(name, light, 1.0)

    def _variance(self, name: str, light: Light, passed: Light | float) -> Light:
        noise, exposure_ms = self.noise(name), self.recording.exposures[name].exposure_ms
        samples_dn = np.maximum(light, 0) * passed * exposure_ms / self.balance
        shared = np.array([1, 2, 1] if self.channels == 3 else [1], np.float32)  # two greens to a cell
        of_sample = (noise.floor_dn2 + noise.slope_dn * samples_dn) / shared
        return np.asarray(of_sample * (self.balance / (passed * exposure_ms)) ** 2, np.float32)

    def middle_s(self, name: str, index: int) -> float:
        """Middle of the exposure of a frame, from the first stamp of the recording [s]."""
        frames = self.recording.exposures[name]
        alone = len(self.recording.exposures) == 1
        after = 0.0 if alone or self.motion is None else self.motion[1]
        return float(frames.stamp_s[index] - after * frames.exposure_ms * 1e-3)

    def moved_px(self, duration_ms: float) -> float:
        """Largest motion of nine tenths of the image in a time, at the usual moment [px of the light]."""
        if self.motion is None:
            return 0.0
        speed = np.linalg.norm(self.motion[0].velocity_px_s[:, ::8, ::8], axis=-1)
        return float(np.median(np.quantile(speed, 0.9, axis=(1, 2)))) * duration_ms * 1e-3 / self.mosaic

    @cached_property
    def steps(self) -> Steps | None:
        """Of the image, from each frame to the next in time; None for a single frame."""
        from tacos_worlds.recorded.motion import shots_of, steps_between

        shots = [shot for own in shots_of(self.recording, self._lights).values() for shot in own]
        return steps_between(shots) if len(shots) > 1 else None

    @cached_property
    def motion(self) -> tuple[Motion, float] | None:
        """Of the image, and where stamps lie in exposures; None for a single frame."""
        if self.steps is None:
            return None
        after_middle = self.steps.stamp_after_middle()
        return self.steps.motion(after_middle), after_middle

    def _cells(self, samples: Light) -> Light:
        """(H, W, C) of (H, W) samples: each cell of the mosaic becomes a pixel."""
        if self.mosaic == 1:
            return samples[..., None]
        height, width = self.size_px
        four = samples[: 2 * height, : 2 * width].reshape(height, 2, width, 2).transpose(0, 2, 1, 3)
        diagonal, across = (four[..., 0, 0], four[..., 1, 1]), (four[..., 0, 1], four[..., 1, 0])
        greens, others = (diagonal, across) if self.recording.green_on_diagonal else (across, diagonal)
        red, blue = others if self.red_first else others[::-1]
        return np.stack([red, (greens[0] + greens[1]) / 2, blue], axis=-1).astype(np.float32)
