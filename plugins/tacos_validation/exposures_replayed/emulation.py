"""One exposure of a recording as another exposure of the same camera."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from tacos_worlds.recorded.motion import Motion, blurred
from tacos_worlds.recorded.noise import LinearNoise
from tacos_worlds.recorded.recording import Recording

Lack = Literal["noise", "blur", "highlights", "shadows"]
"""Too much noise or blur in the source, or clipped highlights or shadows, beside the exposure it is replayed
as."""


@dataclass(frozen=True, eq=False)
class Replay:
    """A source exposure, replayed as a target exposure."""

    recording: Recording
    source: str
    target: str
    light_dn: NDArray[np.float32]  # (N, H, W) light of the source's frames [DN]
    noise: LinearNoise
    motion: Motion  # of the image, measured without the target's frames
    stamp_after_middle: float  # where stamps lie, in exposure times after the middle
    mosaic: int

    @property
    def ratio(self) -> float:
        """Target's exposure over the source's [1]."""
        exposures = self.recording.exposures
        return exposures[self.target].exposure_ms / exposures[self.source].exposure_ms

    @property
    def blur_px(self) -> float:
        """Path of the usual pixel during an exposure of the source, where it is longest [px]."""
        own_ms = self.recording.exposures[self.source].exposure_ms
        speeds = [np.linalg.norm(self.motion.at(s), axis=-1) for s in self._middles_s(self.source)]
        return max(float(np.median(each)) for each in speeds) * own_ms * 1e-3

    def lacks(self) -> tuple[Lack, ...]:
        if self.ratio > 1:
            return ("noise", "shadows") if self.recording.cut_off(self.source) > 0 else ("noise",)
        return ("blur", "highlights") if self.recording.clipped(self.source) > 0 else ("blur",)

    def moments(self) -> tuple[tuple[int, int], ...]:
        """Frames of the source and of the target that were taken nearest to each other, in time order.

        A frame that has none within half a step is left out: what it shows the other never saw.
        """
        own_s, wanted_s = self._middles_s(self.source), self._middles_s(self.target)
        step_s = float(np.median(np.diff(own_s)))
        apart_s = np.abs(wanted_s[:, None] - own_s[None])
        nearest = apart_s.argmin(1)
        return tuple(
            (int(own), wanted)
            for wanted, own in enumerate(nearest)
            if apart_s[wanted, own] <= step_s / 2 and apart_s[:, own].argmin() == wanted
        )

    def _middles_s(self, name: str) -> NDArray[np.float64]:
        frames = self.recording.exposures[name]
        return frames.stamp_s - self.stamp_after_middle * frames.exposure_ms * 1e-3

    def frames(self, rng: np.random.Generator, doubled: Lack | None) -> Iterator[NDArray[np.uint16]]:
        """(H, W) frames as the target would have stored them, with one lack of the source doubled."""
        own_ms = self.recording.exposures[self.source].exposure_ms
        target_ms = self.recording.exposures[self.target].exposure_ms
        own_s, target_s = self._middles_s(self.source), self._middles_s(self.target)
        frames_dn = self._light_lacking(doubled)
        for own, wanted in self.moments():
            light_dn = frames_dn[own]
            middle_s, wanted_ms = target_s[wanted], target_ms
            if doubled == "blur":
                middle_s, wanted_ms = own_s[own], 2 * own_ms - target_ms
            if wanted_ms > own_ms:
                light_dn = blurred(
                    light_dn,
                    self.motion,
                    middle_s=middle_s,
                    own_ms=own_ms,
                    wanted_ms=wanted_ms,
                    mosaic=self.mosaic,
                )
            light_dn = light_dn * np.float32(self.ratio)
            missing_dn2 = self.noise.missing_dn2(light_dn, self.ratio)
            if doubled == "noise":
                missing_dn2 = -missing_dn2
            drawn = rng.standard_normal(light_dn.shape, np.float32) * np.sqrt(np.maximum(missing_dn2, 0))
            yield self.recording.response.codes(light_dn + drawn)

    def _light_lacking(self, doubled: Lack | None) -> NDArray[np.float32]:
        """(N, H, W) light of the source's frames with twice the samples clipped or cut off [DN].

        A response that was told and mended in the highlights is as it was told there: what two responses
        make of them is not to be trusted where it decides.
        """
        light_dn, every_colour = self.light_dn, self.light_dn[:, ::3, ::3]
        if doubled == "shadows":
            share = 2 * self.recording.cut_off(self.source)
            return np.maximum(light_dn, np.float32(np.quantile(every_colour, min(1.0, share))))
        if doubled == "highlights":
            share = 2 * self.recording.clipped(self.source)
            if (told := self.recording.told_response) is not None:
                light_dn = told.light(self.recording.exposures[self.source].codes_dn)
            return np.minimum(light_dn, np.float32(np.quantile(every_colour, max(0.0, 1 - share))))
        return light_dn
