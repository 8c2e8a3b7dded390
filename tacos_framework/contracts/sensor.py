"""Digital images from light."""

from __future__ import annotations

from typing import ClassVar, Protocol

import numpy as np

from tacos_framework.settings import Settings
from tacos_framework.values import Capture, Exposure, FrameBatch, Rig, Signal


class Effects(Protocol):
    """The effects of a recipe that act inside the sensor; the sensor calls each stage at its place."""

    def pixel(self, signal: Signal) -> Signal:
        """Apply the effects on the expected signal, before the noise."""
        ...

    def readout(self, signal: Signal) -> Signal:
        """Apply the effects on noisy samples, before rounding: of the pixel, then of the readout."""
        ...


class Sensor(Protocol):
    """Turns light into digital images, with noise.

    A further member is optional:

    ``lacks(rig) -> str | None``
        What the sensor would have to know of a rig's cameras and does not, in a sentence. A recipe none of
        whose cameras it can serve is refused with it; a candidate it cannot serve fails.
    """

    Config: ClassVar[type[Settings]]

    def expose(
        self,
        capture: Capture,
        *,
        rig: Rig,
        exposure: Exposure,
        rng: np.random.Generator,
        effects: Effects,
    ) -> FrameBatch:
        """The frames of a batch; black and white level are those of the files."""
        ...
