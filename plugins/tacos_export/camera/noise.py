"""The noise of a simulated camera in the units of EMVA 1288."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tacos_framework import Camera, Exposure, Sensor, SensorBase, optional


@dataclass(frozen=True)
class NoiseDescription:
    """The linear camera model of EMVA 1288, one value a channel, of one pixel of the image.

    Electrons are those of all photosites that a pixel averages, as whoever measures the camera counts them.
    ``variance = K (signal - dark) + K^2 sigma_d^2``, before rounding adds 1/12 DN^2.
    """

    system_gain_dn_per_e: tuple[float, ...]  # k [DN/e-]; 0 where the simulation has no photon noise
    temporal_dark_noise_e: tuple[float | None, ...]  # sigma_d [e-]; None without K
    temporal_dark_noise_dn: tuple[float, ...]  # the same in the file [DN]
    saturation_capacity_e: tuple[float | None, ...]
    """Electrons at which the file, or the photosites if they are known to hold less, are full [e-]."""
    black_level_dn: float
    white_level_dn: float  # full scale
    quantum_efficiency: float | None  # as the catalog knows it [1]; None is unknown
    dark_current_e_s: float | None  # likewise [e-/s]
    exposure: Exposure  # the circumstances: the gain is part of K
    origins: Mapping[str, str] = field(default_factory=dict)
    """Where the figures come from, as the sensor model says; empty where it does not."""

    def as_data(self) -> dict[str, Any]:
        return {
            "standard": "EMVA 1288 Release 4.0 Linear; one value for each channel",
            "system_gain_dn_per_e": list(self.system_gain_dn_per_e),
            "temporal_dark_noise_e": list(self.temporal_dark_noise_e),
            "temporal_dark_noise_dn": list(self.temporal_dark_noise_dn),
            "saturation_capacity_e": list(self.saturation_capacity_e),
            "black_level_dn": self.black_level_dn,
            "white_level_dn": self.white_level_dn,
            "quantum_efficiency": self.quantum_efficiency,
            "dark_current_e_s": self.dark_current_e_s,
            "exposure": {
                "exposure_ms": self.exposure.time_s * 1e3,
                "f_number": self.exposure.f_number,
                "gain_db": self.exposure.gain_db,
            },
            "origins": dict(self.origins),
        }


def describe_noise(sensor: Sensor, camera: Camera, exposure: Exposure) -> NoiseDescription:
    """The photon transfer of a sensor model, read off two signals that it says the noise of.

    Any sensor is described, as every one gives mean and variance (`Sensor.moments`).

    Source: EMVA Standard 1288, Release 4.0 Linear, 2021, eq. 13: the photon transfer curve.
    """
    if callable(behind := optional(sensor, SensorBase, "behind")):
        sensor = behind([camera])
    black, white = sensor.black_level_dn, sensor.white_level_dn
    levels = black + np.array([0.0, 0.25]) * (white - black)
    dark_light = np.zeros((1, 1, 1, 3), np.float32)
    channels = sensor.expect(dark_light, camera=camera, exposure=exposure).shape[-1]
    samples = np.broadcast_to(levels[:, None, None, None], (2, 1, 1, channels)).astype(np.float32)
    _, variance = sensor.moments(samples, camera=camera, exposure=exposure)
    dark, bright = np.broadcast_to(variance, samples.shape).reshape(2, channels).astype(np.float64)
    gain = (bright - dark) / (levels[1] - levels[0])
    known, photosites = camera.electrons, camera.binning**2

    def in_electrons(value_dn: float, k: float) -> float | None:
        return _rounded(value_dn / k) if k > 0 else None

    full = [in_electrons(white - black, k) for k in gain]
    if known.full_well_e is not None:
        most = known.full_well_e * photosites
        full = [None if each is None else min(each, most) for each in full]
    return NoiseDescription(
        system_gain_dn_per_e=tuple(map(_rounded, gain)),
        temporal_dark_noise_e=tuple(in_electrons(np.sqrt(v), k) for v, k in zip(dark, gain, strict=True)),
        temporal_dark_noise_dn=tuple(map(_rounded, np.sqrt(dark))),
        saturation_capacity_e=tuple(full),
        black_level_dn=float(black),
        white_level_dn=float(white),
        quantum_efficiency=known.quantum_efficiency,
        dark_current_e_s=None if known.dark_current_e_s is None else known.dark_current_e_s * photosites,
        exposure=exposure,
        origins=origins(camera) if callable(origins := optional(sensor, SensorBase, "origins")) else {},
    )


def _rounded(value: float) -> float:
    """To six figures: the model is single precision."""
    return float(f"{value:.6g}")
