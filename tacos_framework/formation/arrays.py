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
    """A sensor at a camera and an exposure.

    Parameters
    ----------
    use, name
        The component, and its node: the noise it draws follows from the name.
    camera, exposure
        Whose photosites, exposed for how long.
    """

    use: str
    name: str
    sensor: Any
    camera: Camera
    exposure: Exposure

    @cached_property
    def context(self) -> ImageContext:
        """What samples and files of this sensor are."""
        return ImageContext(
            exposure_s=self.exposure.time_s,
            gain_db=self.exposure.gain_db,
            f_number=self.exposure.f_number,
            black_level_dn=self.sensor.black_level_dn,
            white_level_dn=self.sensor.white_level_dn,
            dn_per_electron=self.sensor.dn_per_electron(self.camera, self.exposure),
        )

    def expect(self, light_cd_m2: NDArray[np.float32]) -> Samples:
        """See `tacos_framework.contracts.Sensor.expect`."""
        with calling(self.use, doing="expect"):
            expected = self.sensor.expect(light_cd_m2, camera=self.camera, exposure=self.exposure)
            return checked_samples(self.use, np.asarray(expected, np.float32), light_cd_m2)

    def draw(self, samples_dn: Samples, rng: np.random.Generator, photon_scale: float) -> Samples:
        """See `tacos_framework.contracts.Sensor.draw`."""
        with calling(self.use, doing="draw"):
            drawn = self.sensor.draw(
                samples_dn, camera=self.camera, exposure=self.exposure, rng=rng, photon_scale=photon_scale
            )
            return checked_samples(self.use, np.asarray(drawn, np.float32), samples_dn)


def form_files(
    expected_dn: Samples,
    chain: EffectChain,
    sensor: SensorAt,
    *,
    geometry: ImageGeometry,
    context: ImageContext,
    draws: EpisodeDraws,
    frame: int,
) -> Samples:
    """The values of a file for the expected samples of one frame.

    Parameters
    ----------
    expected_dn
        (1, H, W, C) samples with the pedestal, without noise [DN].
    chain
        The effects of this camera; those on light have acted already.
    geometry, context
        Where the pixels lie, and what is known of them.
    frame
        Its number in the episode.

    Returns
    -------
    NDArray
        (1, H, W, C) float32 whole numbers within 0 and the white level [DN].
    """

    def act(effects: Sequence[ActingEffect], samples: Samples) -> Samples:
        for effect in effects:
            samples = effect.on(samples, geometry=geometry, context=context, draws=draws, frame=frame)
        return samples

    signal = act(chain.pixel, expected_dn)
    rng = draws.rng(frame, "noise", sensor.name, geometry.camera)
    samples = act(chain.readout, sensor.draw(signal, rng, chain.photon_scale))
    files = digital(samples, context.white_level_dn)
    return digital(act(chain.files, files), context.white_level_dn) if chain.files else files


def digital(samples_dn: NDArray[np.floating], white_level_dn: float) -> Samples:
    """Samples rounded to the nearest digital number and clipped to the file's range, in a new array.

    Halves go to the even neighbour, so that rounding has no bias; cutting the fraction off instead would
    darken every image by half a digital number.

    Examples
    --------
    >>> digital(np.float32([-3.0, 0.5, 1.5, 1.4, 254.6, 300.0]), 255).tolist()
    [0.0, 0.0, 2.0, 1.0, 255.0, 255.0]
    """
    rounded = np.rint(np.asarray(samples_dn, np.float32))
    return np.clip(rounded, np.float32(0), np.float32(white_level_dn), out=rounded)


def file_type(white_level_dn: float) -> type[np.unsignedinteger]:
    """What files hold their values in: uint8 where 255 is enough for the white level, else uint16."""
    return np.uint8 if white_level_dn <= 255 else np.uint16


def digitise(samples_dn: NDArray[np.floating], white_level_dn: float) -> NDArray[np.unsignedinteger]:
    """`digital` samples in the type of the file."""
    return digital(samples_dn, white_level_dn).astype(file_type(white_level_dn))
