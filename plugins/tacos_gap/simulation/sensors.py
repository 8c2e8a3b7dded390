"""Sensors of a diagnosis: the noise that ``captures.yaml`` states, or a sensor component in its place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework import (
    Camera,
    CandidateFailed,
    Exposure,
    Fault,
    Rig,
    SensorBase,
    UserError,
    calling,
    optional,
)
from tacos_framework.formation import PlacedSensor, SensorAt
from tacos_gap.captures import Noise, RealCapture
from tacos_plugins.sensors.kept_numbers import KeptNumbers
from tacos_plugins.sensors.noise import add_noise

Samples = NDArray[np.float32]

CAPTURED = "captures.yaml"
"""What stands for the component where ``captures.yaml`` states the noise."""

NODE = "sensor"
"""Name of the sensor in a diagnosis; its noise follows from it."""

HIGHEST = 0.6
"""The signal over full scale up to which noise is taken for affine: below any full well."""


class CapturedNoise:
    """The affine noise of a capture as a sensor; its light is in DN above the pedestal already."""

    def __init__(
        self, noise: Noise, black_level_dn: float, white_level_dn: float, kept: KeptNumbers | None = None
    ):
        self.noise = noise
        self._kept = kept
        self.black_level_dn = black_level_dn
        self.white_level_dn = white_level_dn

    def expect(self, light_cd_m2: Samples, *, camera: Camera, exposure: Exposure) -> Samples:
        return light_cd_m2 + np.float32(self.black_level_dn)

    def moments(
        self, samples_dn: Samples, *, camera: Camera, exposure: Exposure, photon_scale: float = 1.0
    ) -> tuple[Samples, Samples]:
        signal = samples_dn - np.float32(self.black_level_dn)
        return samples_dn, self.noise.variance_dn2(signal, photon_scale)

    def draw(
        self,
        samples_dn: Samples,
        *,
        camera: Camera,
        exposure: Exposure,
        rng: np.random.Generator,
        photon_scale: float = 1.0,
    ) -> Samples:
        noisy = np.empty(samples_dn.shape, np.float32)
        add_noise(
            samples_dn,
            noisy,
            black_level_dn=self.black_level_dn,
            photon_dn=np.asarray(self.noise.photon_dn, np.float32) * np.float32(photon_scale),
            thermal_dn2=np.asarray(self.noise.thermal_dn2, np.float32),
            rng=rng,
            kept=self._kept,
        )
        return noisy

    def dn_per_electron(self, camera: Camera, exposure: Exposure) -> float | None:
        """System gain K, the slope of the photon noise; that of green in colour [DN/e-]."""
        return float(self.noise.photon_dn[len(self.noise.photon_dn) // 2]) or None


def sensor_at(capture: RealCapture, kept: KeptNumbers | None = None) -> SensorAt:
    """The sensor that simulates a capture, at its camera and exposure; `kept` is of `CapturedNoise`."""
    context = capture.context
    if capture.sensor is None:
        own = CapturedNoise(capture.noise, context.black_level_dn, context.white_level_dn, kept)
        return SensorAt(CAPTURED, NODE, own, camera_of(capture), exposure_of(capture))
    placed = capture.sensor
    return SensorAt(placed.use, placed.name, placed.sensor, camera_of(capture), exposure_of(capture))


def camera_of(capture: RealCapture) -> Camera:
    geometry = capture.geometry
    pitch_um = geometry.pixel_um / geometry.binning
    return Camera(
        geometry.camera or "camera",
        geometry.width_px,
        geometry.height_px,
        pixel_um=pitch_um,
        focal_length_mm=geometry.focal_length_px * geometry.pixel_um * 1e-3,
        binning=geometry.binning,
        principal_point_px=geometry.centre_px,
        lens=geometry.lens,
    )


def exposure_of(capture: RealCapture) -> Exposure:
    """Exposure of a capture; nothing of it depends on an unknown f-number."""
    context = capture.context
    known = {} if context.f_number is None else {"f_number": context.f_number}
    return Exposure(time_s=context.exposure_s, gain_db=context.gain_db, **known)


def response_of(sensor: SensorAt, channels: int) -> tuple[Noise, NDArray[np.float64]]:
    """Noise of a sensor as a line over the signal, and (C,) the signal it has without light [DN]."""
    component = sensor.sensor
    black = float(component.black_level_dn)
    samples = np.empty((1, 1, 2, channels), np.float32)
    samples[0, 0, :, :] = [[black], [black + HIGHEST * (component.white_level_dn - black)]]
    with calling(sensor.use, doing="moments"):
        moments = component.moments(samples, camera=sensor.camera, exposure=sensor.exposure)
    mean, variance = (np.broadcast_to(m, samples.shape)[0, 0].astype(np.float64) for m in moments)
    photon = np.maximum((variance[1] - variance[0]) / (mean[1] - mean[0]), 0.0)
    dark = mean[0] - black
    thermal = np.maximum(variance[0] - photon * dark, 0.0)
    return Noise(tuple(photon.tolist()), tuple(thermal.tolist())), dark


def dark_signal(sensor: SensorAt, channels: int) -> NDArray[np.float32]:
    """(C,) what a sensor adds to its samples when it draws, dark current above all [DN]."""
    if isinstance(sensor.sensor, CapturedNoise):
        return np.zeros(channels, np.float32)
    black = np.full((1, 1, 1, channels), sensor.sensor.black_level_dn, np.float32)
    with calling(sensor.use, doing="moments"):
        mean, _ = sensor.sensor.moments(black, camera=sensor.camera, exposure=sensor.exposure)
    return np.asarray((np.broadcast_to(mean, black.shape) - black)[0, 0, 0], np.float32)


def with_sensor(captures: Sequence[RealCapture], placed: PlacedSensor) -> tuple[RealCapture, ...]:
    """Captures that a sensor component simulates, in place of the noise of ``captures.yaml``.

    Raises UserError where the sensor's levels or channels are not those of the files, or it knows too little
    of a camera.
    """
    simulated = []
    for capture in captures:
        sensor = sensor_at(replace(capture, sensor=placed))
        channels = capture.real_dn.shape[-1]
        if faults := _misfits(sensor, capture, channels):
            raise UserError(faults)
        noise, _ = response_of(sensor, channels)
        simulated.append(replace(capture, sensor=placed, noise=noise))
    return tuple(simulated)


def _misfits(sensor: SensorAt, capture: RealCapture, channels: int) -> list[Fault]:
    component: Any = sensor.sensor
    if callable(lacks := optional(component, SensorBase, "lacks")) and (
        reason := lacks(Rig((sensor.camera,)))
    ):
        return [Fault("sensor", reason, "", "Give the missing figures as settings of the sensor.")]
    context, faults = capture.context, []
    for name in ("black_level_dn", "white_level_dn"):
        own, files = float(getattr(component, name)), float(getattr(context, name))
        if own != files:
            what = f"{sensor.use} has a {name} of {own:g}"
            faults.append(Fault("sensor", what, f"{files:g}, that of the files of {capture.id!r}"))
    try:
        given = sensor.expect(np.ones((1, 1, 1, 3), np.float32)).shape[-1]
    except CandidateFailed as failed:
        return [Fault("sensor", str(failed), "", "Give the missing figures as settings of the sensor.")]
    if given != channels:
        what = f"{sensor.use} gives {given} channel{'s' if given > 1 else ''}"
        faults.append(Fault("sensor", what, f"{channels}, as the files of {capture.id!r} have"))
    return faults
