"""Digital images from light."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from tacos_framework.settings import Settings
from tacos_framework.values import Camera, Exposure, Rig

Samples = NDArray[np.float32]
"""(N, H, W, C) samples of one camera with the pedestal, neither rounded nor clipped, C = 1 or 3 [DN]."""


Draw = tuple[int | str, ...]
"""A seed and names, as `tacos_framework.randomness.generator` takes them."""


class Sensor(Protocol):
    """Turns light into samples, and knows their noise.

    A sensor is written on plain arrays of one camera. The framework walks an image through it: expected
    samples, effects of the pixel, the noise, effects of the readout, then rounds and clips to the range of
    the file. The diagnosis of real captures does the same with the same sensor.

    `SensorBase` has optional members.
    """

    Config: ClassVar[type[Settings]]
    black_level_dn: float
    """Pedestal of its files [DN]."""
    white_level_dn: float
    """Full scale of its files, a whole number up to 65535 [DN]."""

    def expect(self, light_cd_m2: NDArray[np.float32], *, camera: Camera, exposure: Exposure) -> Samples:
        """The samples without noise that light makes.

        `light_cd_m2`: (N, H, W, 3) luminance that reaches the pixels, as in `View.luminance_cd_m2`. `camera`,
        `exposure`: who looks, and how long.
        """
        ...

    def moments(
        self, samples_dn: Samples, *, camera: Camera, exposure: Exposure, photon_scale: float = 1.0
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Mean and variance of what `draw` gives for expected samples, where nothing saturates.

        `camera`, `exposure`: as above; of b x b photosites averaged into a pixel (`Camera.binning`) the
        variance is that of the average. `photon_scale`: factor on the variance of the photon noise [1].

        Returns: mean and variance, of the shape of the samples [DN, DN^2].
        """
        ...

    def draw(
        self,
        samples_dn: Samples,
        *,
        camera: Camera,
        exposure: Exposure,
        rng: np.random.Generator,
        photon_scale: float = 1.0,
    ) -> Samples:
        """Noisy samples for expected ones, in an array of their own. `rng` belongs to one frame."""
        ...

    def dn_per_electron(self, camera: Camera, exposure: Exposure) -> float | None:
        """System gain K: samples per electron of a photosite; None if unknown [DN/e-]."""
        ...


class SensorBase:
    """Optional members of a `Sensor`, with their defaults."""

    lacks: Callable[[Rig], str | None] | None = None
    """Unknown figures of a rig's cameras that the sensor needs, in a sentence. A recipe none of
    whose cameras it can serve is refused with it; a candidate it cannot serve fails."""

    origins: Callable[[Camera], Mapping[str, str]] | None = None
    """Origin of each figure of a camera's noise: figure -> ``catalog``, ``settings``, or a phrase, which
    begins with "assumed" where nobody states the figure. Results and exported cameras repeat it."""

    behind: Callable[[Sequence[Camera]], Sensor] | None = None
    """The sensor as it is behind the cameras of a rig, which share the range of their files: with the
    pedestal of their part."""

    assuming: Callable[[Draw], Sensor] | None = None
    """The sensor under one draw of the figures that nobody states; the same draw gives the same sensor. A
    study asks for one in each scene, so that what is not known scatters scores as scenes do."""
