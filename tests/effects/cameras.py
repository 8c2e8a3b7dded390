"""Cameras of other pitch, gain and binning, and images by each of them: binned, or at full pixels."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework.formation import PlacedEffect, SensorAt
from tacos_framework.testing.forming import expose
from tacos_framework.values import Camera, Electrons, Exposure, ImageContext, ImageGeometry
from tacos_plugins.sensors.affine_noise import AffineNoise
from tacos_plugins.sensors.emva import Emva
from tests.small_worlds import captured_light

FOCAL_LENGTH_MM = 4.0
Pattern = Callable[[NDArray[Any], NDArray[Any]], NDArray[Any]]
"""Light over the mean at columns and rows of photosites."""


@dataclass(frozen=True)
class Setup:
    """A camera, how it is set, and the model of its sensor."""

    pixel_um: float
    binning: int
    sensor: Any
    exposure: Exposure
    electrons: Electrons = field(default_factory=lambda: Electrons("any"))

    def camera(self, width_px: int, height_px: int, binning: int) -> Camera:
        """With so many photosites, of which binning x binning make a pixel."""
        return Camera(
            "camera",
            width_px // binning,
            height_px // binning,
            self.pixel_um,
            FOCAL_LENGTH_MM,
            binning=binning,
            electrons=self.electrons,
        )

    @property
    def geometry(self) -> ImageGeometry:
        """Of its photosites."""
        return ImageGeometry.of_camera(self.camera(240, 240, 1))

    @property
    def context(self) -> ImageContext:
        """What is known of its images."""
        camera = self.camera(240, 240, 1)
        return SensorAt("sensor", "frames", self.sensor, camera, self.exposure).context

    def images(
        self,
        pattern: Pattern,
        effects: Sequence[PlacedEffect] = (),
        *,
        electrons: float,
        size: tuple[int, int] = (240, 240),
        frames: int = 1,
        seed: int = 1,
        full: bool = False,
        binning: int | None = None,
    ) -> NDArray[np.float64]:
        """(N, H, W) samples of green above the pedestal, in electrons of a photosite.

        - `pattern`: the light.
        - `effects`: what acts.
        - `electrons`: mean signal [e-].
        - `size`: photosites: height and width.
        - `full`: whether every photosite is simulated and averaged afterwards; else they are binned
          beforehand.
        """
        b = self.binning if binning is None else binning
        height, width = size
        y, x = np.mgrid[:height, :width].astype(np.float64)
        light = pattern(x, y) * electrons / self._electrons_per_luminance()
        if not full:
            light = averaged(light[None], b)[0]
        camera = self.camera(width, height, 1 if full else b)
        capture = captured_light(camera, light[..., None], frames)
        files = expose(self.sensor, capture, effects=effects, exposure=self.exposure, seed=seed).images[0]
        green = files[..., files.shape[-1] // 2].astype(np.float64)
        above = (green - self.context.black_level_dn) / self.context.dn_per_electron
        return averaged(above, b) if full else above

    def _electrons_per_luminance(self) -> float:
        camera = self.camera(1, 1, 1)
        one = np.ones((1, 1, 1, 3), np.float32)
        samples = self.sensor.expect(one, camera=camera, exposure=self.exposure)[..., -2:]
        above = float(samples.ravel()[0]) - self.context.black_level_dn
        return above / self.context.dn_per_electron


def averaged(images: NDArray[Any], binning: int) -> NDArray[Any]:
    """(N, H, W) images averaged over blocks."""
    n, height, width = images.shape
    return images.reshape(n, height // binning, binning, width // binning, binning).mean((2, 4))


def known(full_well_e: float) -> Electrons:
    """A photosite whose own noise is small."""
    return Electrons(
        "any", quantum_efficiency=0.6, full_well_e=full_well_e, read_noise_e=1.0, dark_current_e_s=0.0
    )


def emva(**changes: Any) -> Emva:
    """Images of one channel, so deep that their rounding does not matter."""
    return Emva(Emva.Config(**{"channels": "mono", "bit_depth": 16, "black_level_dn": 2000.0, **changes}))


CAPTURED = Setup(3.0, 1, emva(), Exposure(0.010, 2.0, 0.0), known(10_000.0))
"""The camera at which effects are found."""

CAMERAS = {
    "finer, 6 dB, 4 x 4": Setup(2.0, 4, emva(), Exposure(0.020, 2.0, 6.0), known(8_000.0)),
    "coarser, 15 dB, other sensor, 3 x 3": Setup(
        4.5,
        3,
        AffineNoise(AffineNoise.Config(bit_depth=16, black_level_dn=1000.0)),
        Exposure(0.015, 2.0, 15.0),
    ),
}
"""Those for which it is then designed."""


def bars(period_px: float, depth: float = 0.8) -> Pattern:
    """Bars of a sine, both ways, so many photosites from one to the next."""
    w = 2 * np.pi / period_px
    return lambda x, y: 1 + depth / 2 * (np.sin(w * x) + np.sin(w * y))


def even(x: NDArray[Any], y: NDArray[Any]) -> NDArray[Any]:
    """The same everywhere."""
    return np.ones_like(x)


def wave(images: NDArray[Any], period_px: float, axis: int = 2) -> complex:
    """The wave of a period along an axis: its height over the mean, and its phase."""
    profile = images.mean(axis=(0, 3 - axis))
    edge = round(period_px)
    count = int((len(profile) - 2 * edge) // period_px * period_px)
    at = np.arange(edge, edge + count)
    inside = profile[at]
    found = 2 / count * np.sum(inside * np.exp(-2j * np.pi * at / period_px)) / inside.mean()
    return complex(found)


def placed_at(effect: type[Any], settings: dict[str, Any]) -> PlacedEffect:
    """An effect with settings, as a recipe lists it."""
    return PlacedEffect(f"effect.{effect.__name__}", effect.__name__, effect, effect.Config(**settings))
