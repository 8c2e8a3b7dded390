"""What a sensor component would say of its noise and of its expected signal, found by asking it for frames.

Works for every sensor: they all hand their expected signal to the effects of the stage pixel, and their noisy
samples, not yet rounded, to those of the stage readout.
"""

from __future__ import annotations

import inspect
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework.errors import CandidateFailed, Fault, UserError
from tacos_framework.values import Camera, Capture, Exposure, FrameBatch, Rig, Signal
from tacos_gap.bench.light import without_world
from tacos_gap.captures import Noise

BANDS = 16
"""Levels of signal at which the noise is measured."""

HIGHEST = 0.6
"""The highest of them over full scale: below any full well."""

SIDE_PX = 256
FRAMES = 48
"""Frames of SIDE_PX squared pixels: three million samples, for half a thousandth of a variance."""

_CLEAR_Z = 4.0
"""Standard errors from zero beyond which a dark signal is believed."""


@dataclass(frozen=True)
class Response:
    """Noise before rounding, and what the sensor adds to the signal of light.

    Parameters
    ----------
    noise
        Affine noise [DN, DN^2].
    dark_dn
        (C,) mean signal without light, above the pedestal [DN].
    """

    noise: Noise
    dark_dn: NDArray[np.float64]


def frames_of(
    sensor: Any, capture: Capture, rig: Rig, exposure: Exposure, rng: np.random.Generator, effects: Any
) -> FrameBatch:
    """Frames of a sensor, which is given what it asks for."""
    offered = {"rig": rig, "exposure": exposure, "rng": rng, "effects": effects}
    wanted = inspect.signature(sensor.expose).parameters
    try:
        batch: FrameBatch = sensor.expose(capture, **{k: v for k, v in offered.items() if k in wanted})
    except CandidateFailed as failed:
        remedy = "Give the missing figures as settings of the sensor."
        raise UserError(Fault("sensor", str(failed), "", remedy)) from failed
    return batch


def expected_signal(sensor: Any, capture: Capture, rig: Rig, exposure: Exposure) -> Signal:
    """Samples that light alone makes in the first camera, neither rounded nor clipped [DN]."""
    asked = _Recorder()
    frames_of(sensor, capture, rig, exposure, np.random.default_rng(0), asked)
    return asked.expected[0]


def measured_response(sensor: Any, camera: Camera, exposure: Exposure, rng: np.random.Generator) -> Response:
    """Noise and dark signal of a camera's sensor, from frames of a ramp."""
    camera = replace(camera, width_px=SIDE_PX, height_px=SIDE_PX, principal_point_px=None)
    rig = Rig((camera,))
    unit = expected_signal(sensor, _even(camera, np.ones(SIDE_PX)), rig, exposure)
    per_luminance = float(unit.samples_dn.max()) - unit.black_level_dn
    top = HIGHEST * (unit.white_level_dn - unit.black_level_dn) / per_luminance
    ramp = _even(camera, top * np.repeat(np.arange(BANDS) / (BANDS - 1), SIDE_PX // BANDS))
    added, squares = 0.0, 0.0
    for _ in range(FRAMES):
        asked = _Recorder()
        frames_of(sensor, ramp, rig, exposure, rng, asked)
        difference = asked.noisy[0].samples_dn.astype(np.float64) - asked.expected[0].samples_dn
        banded = difference.reshape(BANDS, -1, difference.shape[-1])
        added, squares = added + banded.sum(axis=1), squares + (banded**2).sum(axis=1)
    count = FRAMES * SIDE_PX * SIDE_PX // BANDS
    mean_dn = np.asarray(added / count)
    variance_dn2 = np.asarray(squares / count) - mean_dn**2
    signal = asked.expected[0].samples_dn[0].reshape(BANDS, -1, mean_dn.shape[1]).mean(axis=1)
    signal_dn = signal.astype(np.float64) - unit.black_level_dn
    lines = [_line(signal_dn[:, c], variance_dn2[:, c]) for c in range(mean_dn.shape[1])]
    photon_dn, thermal_dn2 = zip(*lines, strict=True)
    dark_dn = mean_dn[0]
    error_dn = np.sqrt(np.maximum(variance_dn2[0], 1e-12) / count)
    return Response(
        Noise(photon_dn, thermal_dn2), np.where(np.abs(dark_dn) > _CLEAR_Z * error_dn, dark_dn, 0.0)
    )


def _line(signal_dn: NDArray[np.float64], variance_dn2: NDArray[np.float64]) -> tuple[float, float]:
    """Slope and intercept, each level weighed by what its variance is known to; neither below 0."""
    weight = 1 / np.maximum(variance_dn2, 1e-9)
    slope, intercept = np.polyfit(signal_dn, variance_dn2, 1, w=weight)
    return max(float(slope), 0.0), max(float(intercept), 0.0)


def _even(camera: Camera, luminance_of_row: NDArray[np.float64]) -> Capture:
    """A view whose rows are evenly bright, without a world behind it."""
    size = (1, camera.height_px, camera.width_px)
    light = np.broadcast_to(luminance_of_row[None, :, None, None], (*size, 3)).astype(np.float32)
    return without_world(camera, light)


class _Recorder:
    """Effects that change nothing and keep what they are shown."""

    def __init__(self) -> None:
        self.expected: list[Signal] = []
        self.noisy: list[Signal] = []

    def pixel(self, signal: Signal) -> Signal:
        self.expected.append(signal)
        return signal

    def readout(self, signal: Signal) -> Signal:
        self.noisy.append(signal)
        return signal
