"""The effects of the recipe, bound to a camera."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from tacos_framework.contracts import acts_after_noise
from tacos_framework.plan import Part
from tacos_framework.values import Capture, Exposure, FrameBatch, Rig, Signal


class ActingEffects:
    """The effects of the recipe, bound to a candidate; implements `tacos_framework.contracts.Effects`."""

    def __init__(
        self,
        effects: Sequence[tuple[Part, Any]],
        rig: Rig,
        exposure: Exposure,
        rng: np.random.Generator,
    ):
        self._effects = effects
        self._supplied = {"rig": rig, "exposure": exposure, "rng": rng}

    def _apply(self, image: Any, *stages: str, after_noise: bool) -> Any:
        for part, effect in self._effects:
            if part.cls.stage in stages and acts_after_noise(part.cls) is after_noise:
                try:
                    image = effect.apply(image, **self._supplied)
                except Exception as error:
                    error.add_note(f"in {part.use}")
                    raise
        return image

    def light(self, capture: Capture) -> Capture:
        """Effects on light on its way to the pixels."""
        return self._apply(capture, "scene", "optics", "exposure", after_noise=False)

    def pixel(self, signal: Signal) -> Signal:
        """Effects on the expected signal, before the noise."""
        return self._apply(signal, "pixel", after_noise=False)

    def readout(self, signal: Signal) -> Signal:
        """Effects on noisy samples."""
        return self._apply(signal, "pixel", "readout", after_noise=True)

    def files(self, frames: FrameBatch) -> FrameBatch:
        """Effects on digital images."""
        return self._apply(frames, "isp", "codec", after_noise=True)
