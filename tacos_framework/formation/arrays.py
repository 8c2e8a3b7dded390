"""From expected samples to the values of a file, on arrays of one camera and one frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework.formation.chain import ActingEffect, EffectChain
from tacos_framework.formation.checked import checked_samples
from tacos_framework.formation.draws import EpisodeDraws
from tacos_framework.plugins.guarded import calling
from tacos_framework.values import Camera, Exposure, ImageContext, ImageGeometry

Samples = NDArray[np.float32]


@dataclass(frozen=True)
class SensorAt:
    """A sensor at a camera and an exposure."""

    use: str
    name: str
    """The component, and its node: the noise it draws follows from the name."""
    sensor: Any
    camera: Camera
    exposure: Exposure
    """Whose photosites, exposed for how long."""

    @cached_property
    def context(self) -> ImageContext:
        """Circumstances of samples and files of this sensor."""
        return ImageContext(
            exposure_s=self.exposure.time_s,
            gain_db=self.exposure.gain_db,
            f_number=self.exposure.f_number,
            black_level_dn=self.sensor.black_level_dn,
            white_level_dn=self.sensor.white_level_dn,
            dn_per_electron=self.sensor.dn_per_electron(self.camera, self.exposure),
        )

    def expect(self, light_cd_m2: NDArray[np.float32]) -> Samples:
        with calling(self.use, doing="expect"):
            expected = self.sensor.expect(light_cd_m2, camera=self.camera, exposure=self.exposure)
            return checked_samples(self.use, np.asarray(expected, np.float32), light_cd_m2)

    def draw(
        self,
        samples_dn: Samples,
        rng: np.random.Generator,
        photon_scale: float,
        carried_dn2: NDArray[np.float32] | None = None,
        dark_scale: float = 1.0,
    ) -> Samples:
        """See `tacos_framework.contracts.Sensor.draw`.

        Of noise that the samples carry already, `carried_dn2` of variance, only the rest is added. The noise
        without light has `dark_scale` of its variance.
        """
        with calling(self.use, doing="draw"):
            drawn = self.sensor.draw(
                samples_dn, camera=self.camera, exposure=self.exposure, rng=rng, photon_scale=photon_scale
            )
            drawn = checked_samples(self.use, np.asarray(drawn, np.float32), samples_dn)
            if carried_dn2 is None and dark_scale == 1.0:
                return drawn
            mean_dn, variance_dn2 = self.sensor.moments(
                samples_dn, camera=self.camera, exposure=self.exposure, photon_scale=photon_scale
            )
            black = np.full((1, 1, 1, samples_dn.shape[-1]), self.sensor.black_level_dn, np.float32)
            _, dark_dn2 = self.sensor.moments(black, camera=self.camera, exposure=self.exposure)
        left_out_dn2 = (0 if carried_dn2 is None else carried_dn2) + np.float32(1 - dark_scale) * dark_dn2
        return without_carried(drawn, mean_dn, variance_dn2, left_out_dn2)

    def carried_dn2(
        self, light_cd_m2: NDArray[np.float32], noise_cd2_m4: NDArray[np.float32], expected_dn: Samples
    ) -> NDArray[np.float32]:
        """Variance in the samples of noise that is in the light already, of the samples' shape [DN^2].

        `noise_cd2_m4`: see `View.noise_cd2_m4`.
        """
        one = np.eye(3, dtype=np.float32) if noise_cd2_m4.shape[-1] == 3 else np.ones((1, 3), np.float32)
        variance_dn2 = np.zeros_like(expected_dn)
        for channel, step in enumerate(one):
            slope = self.expect(light_cd_m2 + step) - expected_dn
            variance_dn2 += slope**2 * noise_cd2_m4[..., channel : channel + 1]
        return variance_dn2


_SATURATED = 6.0
"""Samples this many standard deviations from what is expected are so by a full well, and stay."""


def without_carried(
    drawn_dn: Samples, mean_dn: Samples, variance_dn2: Samples, carried_dn2: NDArray[np.float32]
) -> Samples:
    """Noisy samples whose noise is smaller by what the expected samples carry already.

    >>> one = np.ones(1, np.float32)
    >>> without_carried(one * 5, one, one * 16, one * 7).tolist()  # 4 becomes 3: the rest of 16 is 9
    [4.0]
    """
    noise = drawn_dn - mean_dn
    left = np.maximum(1 - carried_dn2 / np.maximum(variance_dn2, np.float32(1e-12)), 0)
    unsaturated = noise**2 <= _SATURATED**2 * variance_dn2
    return np.where(unsaturated, mean_dn + noise * np.sqrt(left), drawn_dn).astype(np.float32)


def form_files(
    expected_dn: Samples,
    chain: EffectChain,
    sensor: SensorAt,
    *,
    geometry: ImageGeometry,
    context: ImageContext,
    draws: EpisodeDraws,
    frame: int,
    carried_dn2: NDArray[np.float32] | None = None,
) -> Samples:
    """The values of a file for the expected samples of one frame.

    - `expected_dn`: (1, H, W, C) samples with the pedestal, without noise [DN].
    - `chain`: the effects of this camera; those on light have acted already.
    - `geometry`, `context`: where the pixels lie, and what is known of them.
    - `frame`: its number in the episode.
    - `carried_dn2`: variance of noise that the expected samples carry, as their light was itself recorded
      [DN^2].

    Returns: (1, H, W, C) float32 whole numbers within 0 and the white level [DN].
    """

    def act(effects: Sequence[ActingEffect], samples: Samples) -> Samples:
        for effect in effects:
            samples = effect.on(samples, geometry=geometry, context=context, draws=draws, frame=frame)
        return samples

    signal = act(chain.pixel, expected_dn)
    rng = draws.rng(frame, "noise", sensor.name, geometry.camera)
    samples = act(chain.readout, sensor.draw(signal, rng, chain.photon_scale, carried_dn2, chain.dark_scale))
    files = digital(samples, context.white_level_dn)
    return digital(act(chain.files, files), context.white_level_dn) if chain.files else files


def digital(samples_dn: NDArray[np.floating], white_level_dn: float) -> Samples:
    """Samples rounded to the nearest digital number and clipped to the file's range, in a new array.

    Halves go to the even neighbour, so that rounding has no bias; cutting the fraction off instead would
    darken every image by half a digital number.

    >>> digital(np.float32([-3.0, 0.5, 1.5, 1.4, 254.6, 300.0]), 255).tolist()
    [0.0, 0.0, 2.0, 1.0, 255.0, 255.0]
    """
    rounded = np.rint(np.asarray(samples_dn, np.float32))
    return np.clip(rounded, np.float32(0), np.float32(white_level_dn), out=rounded)


def file_type(white_level_dn: float) -> type[np.unsignedinteger]:
    """Data type of files: uint8 where 255 is enough for the white level, else uint16."""
    return np.uint8 if white_level_dn <= 255 else np.uint16


def digitise(samples_dn: NDArray[np.floating], white_level_dn: float) -> NDArray[np.unsignedinteger]:
    """`digital` samples in the type of the file."""
    return digital(samples_dn, white_level_dn).astype(file_type(white_level_dn))
