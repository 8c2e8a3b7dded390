"""The scene `scene.light-box`: an even white surface, for flats and exposure series."""

from __future__ import annotations

from tacos_framework import Episode, Settings, setting
from tacos_worlds.bench.stand import matte, square, standing, tent_world


class LightBox:
    """An even, white, matte surface across the whole view of any camera.

    It stands for the mouth of an integrating sphere, or for a screen or light panel behind a diffuser close
    to the lens.
    """

    class Config(Settings):
        reflectance: float = setting(1.0, help="Reflectance of the surface.", gt=0, le=1)
        distance_m: float = setting(0.1, help="From the camera to the surface.", unit="m", gt=0)
        frames: int = setting(1, help="Frames taken.", ge=1, le=1_000_000)

    def __init__(self, config: Config) -> None:
        self.config = config

    def episode(self, *, illumination_lux: float) -> Episode:
        config = self.config
        world = tent_world(
            f"scene.light-box {config.reflectance!r} {config.distance_m!r}",
            [square(config.distance_m, 20 * config.distance_m)],  # seen up to 87 degrees off the axis
            [matte("white", config.reflectance)],
            illumination_lux=illumination_lux,
        )
        return standing(world, config.frames)
