"""Lamps on alternating current, seen row by row."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from tacos_framework import (
    Captures,
    ImageContext,
    ImageGeometry,
    ObservedCapture,
    Settings,
    ShownBy,
    Stage,
    lit,
    setting,
)
from tacos_plugins.effects.row_waves import SHADING_DEGREE, amplitudes
from tacos_plugins.effects.samples import Samples
from tacos_plugins.effects.shown_by import LAMPS


class Flicker:
    """Multiplies the light by a wave over the rows:

        1 + depth sin(2 pi row / period_rows + phase)

    Rows are those of the full sensor's photosites; a binned row averages over its own. The lamp does not
    know of the camera, so each frame draws its own phase. There is no wave in the dark, unlike with noise of
    rows.
    """

    class Config(Settings):
        depth: float = setting(0.0, help="Height of the wave over the mean.", ge=0, le=1)
        period_rows: float = setting(
            200.0, help="Rows read out in one period of the light.", unit="row", ge=2, le=1e6
        )

    stage: ClassVar[Stage] = "exposure"
    rank: ClassVar[int] = 30
    neutral: ClassVar[Mapping[str, Any]] = {"depth": 0.0}
    initial_guesses: ClassVar[Sequence[Mapping[str, Any]]] = ({"depth": 0.05, "period_rows": 150.0},)
    frames_differ: ClassVar[bool] = True
    shown_by: ClassVar[Sequence[ShownBy]] = (LAMPS,)

    def __init__(self, config: Config) -> None:
        self.config = config

    @classmethod
    def guesses_from(cls, captures: Captures) -> Iterator[Mapping[str, Any]]:
        """The three strongest waves over the rows that differ by more than a quarter."""
        depths = wave_depths(captures)
        chosen: list[float] = []
        for period in sorted(depths, key=lambda period: -depths[period]):
            if all(abs(math.log(period / other)) > 0.25 for other in chosen):
                chosen.append(period)
            if len(chosen) == 3:
                break
        for period in chosen:
            yield {"depth": max(depths[period], 0.005), "period_rows": period}

    def on_array(
        self, signal: Samples, *, geometry: ImageGeometry, context: ImageContext, rng: np.random.Generator
    ) -> Samples:
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

    - `depth`: height of the wave over the mean, in a row of photosites [1].
    - `period_rows`: rows of the image in one period [row].
    - `phase_rad`: (N,) phase in the sensor's row 0 [rad].

    Returns: (N, H, 1) float64 [1].

    Examples
    --------
    >>> geometry = ImageGeometry(1, 4, focal_length_px=4.0, centre_px=(0.0, 1.5), pixel_um=3)
    >>> lamp_wave(geometry, depth=0.5, period_rows=4, phase_rad=np.zeros(1)).round(3).ravel().tolist()
    [1.0, 1.5, 1.0, 0.5]
    """
    angle = 2 * math.pi * geometry.sensor_row / period_rows
    row = math.pi / (period_rows * geometry.binning)  # half the phase from photosite to photosite
    depth *= math.sin(row * geometry.binning) / (geometry.binning * math.sin(row))
    return np.asarray(1 + depth * np.sin(angle + phase_rad[:, None, None]))


def wave_depths(captures: Captures) -> dict[float, float]:
    """Depth of the waves over the rows that captures show beside what is expected [1], by period [row].

    Those with the most rows tell it, at periods between whole fractions of their height, too. Of three frames
    or more what stays from frame to frame is left out, of fewer what is smooth.
    """
    seen = [c for c in lit(captures) if c.expected_dn is not None]
    height = max((c.real_dn.shape[1] for c in seen), default=0)
    periods = [round(8 * height / k, 2) for k in range(6, min(8 * 60, 4 * height))]
    found = [_depths_of(c, periods) for c in seen if c.real_dn.shape[1] == height]
    return dict(zip(periods, np.mean(found, axis=0).tolist(), strict=True)) if found else {}


def _depths_of(capture: ObservedCapture, periods: Sequence[float]) -> NDArray[np.float64]:
    """(K,) mean over frames of the depths of waves of K `periods` [row]."""
    assert capture.expected_dn is not None
    signal = np.maximum(capture.expected_dn.mean(axis=0).mean(axis=-1), 1.0).sum(axis=1)
    rows = (capture.real_dn - capture.expected_dn).mean(axis=-1).sum(axis=2) / signal
    if len(rows) > 2:
        return amplitudes(rows - rows.mean(axis=0), periods).mean(axis=0)
    return amplitudes(rows, periods, SHADING_DEGREE).mean(axis=0)
