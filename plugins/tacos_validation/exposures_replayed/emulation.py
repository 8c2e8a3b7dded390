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

Lack = Literal["noise", "blur", "highlights"]
"""Too much noise or blur in the source, or clipped highlights, beside the exposure it is replayed as."""


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
    def clipped(self) -> float:
        """Share of the source's samples of which light is unknown, and the target's would not be [1]."""
        return float(np.mean(self.light_dn >= self.recording.top_dn)) if self.ratio < 1 else 0.0

    def lacks(self) -> tuple[Lack, ...]:
        if self.ratio > 1:
            return ("noise",)
        return ("blur", "highlights") if self.clipped > 0 else ("blur",)

    def frames(self, rng: np.random.Generator, doubled: Lack | None) -> Iterator[NDArray[np.uint16]]:
        """(H, W) frames as the target would have stored them, with one lack of the source doubled."""
        source = self.recording.exposures[self.source]
        target = self.recording.exposures[self.target]
        clip_dn = np.inf
        if doubled == "highlights":
            every_colour = self.light_dn[:, ::3, ::3]
            clip_dn = float(np.quantile(every_colour, max(0.0, 1 - 2 * self.clipped)))
        for index, light_dn in enumerate(self.light_dn):
            light_dn = np.minimum(light_dn, np.float32(clip_dn))
            at = min(index, len(target.stamp_s) - 1)
            middle_s = target.stamp_s[at] - self.stamp_after_middle * target.exposure_ms * 1e-3
            wanted_ms = target.exposure_ms
            if doubled == "blur":
                middle_s = source.stamp_s[index] - self.stamp_after_middle * source.exposure_ms * 1e-3
                wanted_ms = 2 * source.exposure_ms - target.exposure_ms
            if wanted_ms > source.exposure_ms:
                light_dn = blurred(
                    light_dn,
                    self.motion,
                    middle_s=middle_s,
                    own_ms=source.exposure_ms,
                    wanted_ms=wanted_ms,
                    mosaic=self.mosaic,
                )
            light_dn = light_dn * np.float32(self.ratio)
            missing_dn2 = self.noise.missing_dn2(light_dn, self.ratio)
            if doubled == "noise":
                missing_dn2 = -missing_dn2
            drawn = rng.standard_normal(light_dn.shape, np.float32) * np.sqrt(np.maximum(missing_dn2, 0))
            yield self.recording.response.codes(light_dn + drawn)
