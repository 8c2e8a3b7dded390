"""Lamps on alternating current, seen row by row."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from tacos_framework.contracts import Stage
from tacos_framework.settings import Settings, setting
from tacos_framework.values import ImageContext, ImageGeometry


class Flicker:
    """Multiplies the light by a wave over the rows:

        1 + depth sin(2 pi row / period_rows + phase)

    Rows are those of the full sensor. The lamp does not know of the camera, so each frame draws its own
    phase. There is no wave in the dark, unlike with noise of rows.
    """

    class Config(Settings):
        """Settings of the effect."""

        depth: float = setting(0.0, help="Height of the wave over the mean.", ge=0, le=1)
        period_rows: float = setting(
            200.0, help="Rows read out in one period of the light.", unit="row", ge=2, le=1e6
        )

    stage: ClassVar[Stage] = "exposure"
    rank: ClassVar[int] = 30
    neutral: ClassVar[Mapping[str, Any]] = {"depth": 0.0}
    initial_guesses: ClassVar[Sequence[Mapping[str, Any]]] = ({"depth": 0.05, "period_rows": 150.0},)

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
        """Light times the wave, at a random phase in each frame."""
        if self.config.depth == 0.0:
            return signal
        phase = rng.uniform(0.0, 2 * math.pi, len(signal))
        wave = lamp_wave(geometry, self.config.depth, self.config.period_rows, phase)
        return signal * wave.astype(signal.dtype)[..., None]


def lamp_wave(
    geometry: ImageGeometry, depth: float, period_rows: float, phase_rad: NDArray[np.float64]
) -> NDArray[np.float64]:
    """The factor on the light of each row.

    Parameters
    ----------
    geometry
        The image.
    depth
        Height of the wave over the mean [1].
    period_rows
        Rows read out in one period [row].
    phase_rad
        (N,) phase in the sensor's row 0 [rad].

    Returns
    -------
    NDArray
        (N, H, 1) float64 [1].

    Examples
    --------
    >>> geometry = ImageGeometry(1, 4, focal_length_px=4.0, centre_px=(0.0, 1.5), pixel_um=3)
    >>> lamp_wave(geometry, depth=0.5, period_rows=4, phase_rad=np.zeros(1)).round(3).ravel().tolist()
    [1.0, 1.5, 1.0, 0.5]
    """
    angle = 2 * math.pi * geometry.sensor_row / period_rows
    return np.asarray(1 + depth * np.sin(angle + phase_rad[:, None, None]))
