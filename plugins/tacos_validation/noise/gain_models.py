"""Three ways to carry noise measured at some gains of a camera over to another gain."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from tacos_validation.noise.gain_table import MeasuredCamera
from tacos_validation.noise.two_stage_noise import Noise, NoiseOverGain

Prediction = Callable[[float], Noise]
"""Noise at a gain."""

BIT_DEPTH = 14
"""Of the raw files that the profiles of still cameras come from; sets the rounding of the electron model."""

_ROUNDING = 1 / (12 * (2**BIT_DEPTH - 1) ** 2)
_UNKNOWN_SD = 1.0


def affine(camera: MeasuredCamera) -> Prediction:
    """``a = s G, b = t G^2`` (paper, eq. 1)."""
    return _scaled(camera, rounding=0.0)


def electrons(camera: MeasuredCamera) -> Prediction:
    """One read noise in electrons, and rounding: ``b = K^2 r^2 + 1/12`` (EMVA 1288, eq. 13)."""
    return _scaled(camera, rounding=_ROUNDING)


def two_stages(camera: MeasuredCamera) -> Prediction:
    """Noise before and after the gain, with departures as `NoiseOverGain` has them."""
    return NoiseOverGain(camera.gains, camera.slopes, camera.intercepts).at


MODELS: Mapping[str, Callable[[MeasuredCamera], Prediction]] = MappingProxyType(
    {"affine": affine, "electrons": electrons, "two-stages": two_stages}
)


def _scaled(camera: MeasuredCamera, rounding: float) -> Prediction:
    dark = camera.intercepts > 0
    slope, slope_sd = _middle(np.log(camera.slopes / camera.gains))
    read_out = np.maximum(camera.intercepts[dark] - rounding, 0.1 * camera.intercepts[dark])
    intercept, intercept_sd = _middle(np.log(read_out / camera.gains[dark] ** 2))

    def at(gain: float) -> Noise:
        return Noise(
            slope=float(np.exp(slope) * gain),
            intercept=float(np.exp(intercept) * gain**2 + rounding),
            slope_sd=slope_sd,
            intercept_sd=intercept_sd,
        )

    return at


def _middle(logs: NDArray[np.float64]) -> tuple[float, float]:
    """Median, and the scatter of one value about it."""
    spread = float(np.std(logs, ddof=1)) if len(logs) > 1 else _UNKNOWN_SD
    return float(np.median(logs)), max(spread, 1e-6)
