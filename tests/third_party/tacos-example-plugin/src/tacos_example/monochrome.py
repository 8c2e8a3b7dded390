"""Electrons of a monochrome sensor with shot and read noise."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from tacos_framework.camera.colour import luminance
from tacos_framework.camera.exposure import digitise, exposure_per_luminance
from tacos_framework.contracts import Effects
from tacos_framework.settings import Settings, setting
from tacos_framework.values import Capture, Exposure, FrameBatch, Signal, View

WHITE_LEVEL_DN = 255


class MonochromeSensor:
    """Counts electrons of the luminance, without colour filters.

    A photosite of pitch p collects ``sensitivity p^2 H`` electrons from a focal-plane exposure H. Shot noise
    has their number as its variance, read noise a constant one; the full well is white at a gain of 0 dB.
    """

    class Config(Settings):
        """Settings of the sensor."""

        sensitivity_e_per_lux_s_um2: float = setting(
            2500.0,
            help="Electrons for each lux second and um2; 2500 is a quantum efficiency of 0.6 in green light.",
            unit="e/(lux s um2)",
            gt=0,
        )
        full_well_e: float = setting(10_000.0, help="Electrons of a full photosite.", unit="e", gt=0)
        read_noise_e: float = setting(2.0, help="Standard deviation of read noise.", unit="e", ge=0)

    def __init__(self, config: Config) -> None:
        self.config = config

    def expose(
        self, capture: Capture, *, exposure: Exposure, rng: np.random.Generator, effects: Effects
    ) -> FrameBatch:
        """Frames of one channel, uint8."""
        expected = [effects.pixel(self._expected(view, exposure)) for view in capture.views]
        noisy = [np.empty_like(signal.samples_dn) for signal in expected]
        for frame in range(len(capture.episode)):  # in this order, so that batches may be cut anywhere
            for signal, out in zip(expected, noisy, strict=True):
                out[frame] = self._with_noise(signal, frame, exposure, rng)
        read = [
            effects.readout(Signal(view, samples, 0.0, WHITE_LEVEL_DN))
            for view, samples in zip(capture.views, noisy, strict=True)
        ]
        images = tuple(digitise(signal.samples_dn, WHITE_LEVEL_DN) for signal in read)
        return FrameBatch(capture, images, black_level_dn=0.0, white_level_dn=WHITE_LEVEL_DN)

    def _dn_per_e(self, exposure: Exposure) -> float:
        return WHITE_LEVEL_DN / self.config.full_well_e * exposure.gain

    def _expected(self, view: View, exposure: Exposure) -> Signal:
        lux_s = luminance(view.luminance_cd_m2) * exposure_per_luminance(exposure.time_s, exposure.f_number)
        pitch_um = view.camera.pixel_um
        electrons = lux_s * self.config.sensitivity_e_per_lux_s_um2 * pitch_um**2
        samples = (electrons * self._dn_per_e(exposure))[..., None].astype(np.float32)
        return Signal(view, samples, 0.0, WHITE_LEVEL_DN)

    def _with_noise(
        self, signal: Signal, frame: int, exposure: Exposure, rng: np.random.Generator
    ) -> NDArray[np.float32]:
        """One frame with noise; simulated pixels that average photosites have less of it."""
        samples, dn_per_e = signal.samples_dn[frame], np.float32(self._dn_per_e(exposure))
        photosites = np.float32(signal.view.camera.binning**2)
        variance_e2 = np.maximum(samples / dn_per_e, 0) + np.float32(self.config.read_noise_e**2)
        sigma_dn = dn_per_e * np.sqrt(variance_e2 / photosites)
        return samples + sigma_dn * rng.standard_normal(samples.shape, dtype=np.float32)
