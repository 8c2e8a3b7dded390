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
from tacos_plugins.effects.row_waves import SHADING_DEGREE, CommonWave, amplitudes, common_wave
from tacos_plugins.effects.samples import Samples
from tacos_plugins.effects.shown_by import LAMPS

_MOSTLY = 0.5
"""Share of what differs between frames from which on a wave is looked for at its own period alone."""


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
        """The wave that parts repeated frames; without such, the three strongest
        waves over the rows that differ by more than a quarter.
        """
        if (wave := wave_between_frames(captures)) is not None:
            yield {"depth": max(wave.amplitude, 0.005), "period_rows": wave.period}
            return
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


def wave_between_frames(captures: Captures) -> CommonWave | None:
    """The wave by which frames of one picture differ, where most of their difference is one.

    Nothing in a scene differs so. The period is sure within a row or two, where a comparison with simulated
    frames hangs on the luck of the phases.
    """
    rows = [profiles for profiles in _profiles_of_tallest(captures) if len(profiles) > 2]
    if not rows:
        return None
    wave = common_wave(rows, _periods(rows[0].shape[1], 32, 8))
    return wave if wave.share > _MOSTLY else None


def wave_depths(captures: Captures) -> dict[float, float]:
    """Depth of the waves over the rows that captures show beside what is smooth [1], by period [row].

    Those with the most rows tell it, at periods between whole fractions of their height, too.
    """
    rows = _profiles_of_tallest(captures)
    if not rows:
        return {}
    periods = _periods(rows[0].shape[1], 8, 6)
    found = [amplitudes(profiles, periods, SHADING_DEGREE).mean(axis=0) for profiles in rows]
    return dict(zip(periods, np.mean(found, axis=0).tolist(), strict=True))


def _periods(height: int, finer: int, longest: int) -> list[float]:
    """Periods of 2 rows to `finer` / `longest` times the height, `finer` times as dense as its fractions."""
    return [round(finer * height / k, 2) for k in range(longest, min(finer * 60, finer * height // 2))]


def _profiles_of_tallest(captures: Captures) -> list[NDArray[np.float64]]:
    """(N, H) rows of each frame beside what is expected, over their light, of the captures with most rows."""
    seen = [c for c in lit(captures) if c.expected_dn is not None]
    height = max((c.real_dn.shape[1] for c in seen), default=0)
    return [_profiles(capture) for capture in seen if capture.real_dn.shape[1] == height]


def _profiles(capture: ObservedCapture) -> NDArray[np.float64]:
    assert capture.expected_dn is not None
    lit_dn = capture.expected_dn.mean(axis=0).mean(axis=-1) - capture.context.black_level_dn
    signal = np.maximum(lit_dn, 1.0).sum(axis=1)
    return np.asarray((capture.real_dn - capture.expected_dn).mean(axis=-1).sum(axis=2) / signal, np.float64)
