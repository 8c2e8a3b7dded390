"""The image moves while the shutter is open."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from tacos_framework.camera.blur import blur, kernel_of, line_transfer
from tacos_framework.contracts import Stage
from tacos_framework.settings import Settings, setting
from tacos_framework.values import ImageContext, ImageGeometry


class MotionBlur:
    """Smears the light evenly along a straight line, alike all over the image.

    The line lies half on either side of each pixel, so that the image does not shift. Its transfer is
    ``sin(pi L f) / (pi L f)`` for frequencies along it and 1 across.
    """

    class Config(Settings):
        """Settings of the effect."""

        length_px: float = setting(
            0.0, help="Length of the path during the exposure.", unit="px", ge=0, le=200
        )
        angle_deg: float = setting(
            0.0,
            help="Direction of the path: 0 along the rows, 90 along the columns, turning clockwise.",
            unit="deg",
            ge=-360,
            le=360,
        )

    stage: ClassVar[Stage] = "exposure"
    rank: ClassVar[int] = 10
    neutral: ClassVar[Mapping[str, Any]] = {"length_px": 0.0}
    initial_guesses: ClassVar[Sequence[Mapping[str, Any]]] = (
        {"length_px": 5.0, "angle_deg": 0.0},
        {"length_px": 5.0, "angle_deg": 45.0},
        {"length_px": 5.0, "angle_deg": 90.0},
        {"length_px": 5.0, "angle_deg": 135.0},
    )

    def __init__(self, config: Config) -> None:
        self.config = config

    def on_array(
        self,
        signal: NDArray[np.floating],
        *,
        geometry: ImageGeometry,
        context: ImageContext,
        rng: np.random.Generator,
    ) -> NDArray[np.floating]:
        """Light smeared along the line."""
        length_px = self.config.length_px
        if length_px == 0.0:
            return signal
        transfer = line_transfer(length_px, self.config.angle_deg)
        return blur(signal, kernel_of(transfer, reach_px=length_px / 2))
