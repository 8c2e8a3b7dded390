"""The scene `scene.grey-bars`: upright bars from black to white, to measure noise with."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from tacos_framework import Episode, Settings, setting
from tacos_worlds.bench.stand import bench_world, facing, matte, standing


class GreyBars:
    """A flat target of upright grey bars, evenly spaced in reflectance, black on the left.

    The target stands upright in front of the agent, which does not move. Here the scenario's illuminance is
    that on the target, as a light meter laid on it would show. Light comes from a panel above the camera, so
    it is not quite even; see `tacos_worlds.bench.stand`.

    Source: The paper, supplement, Sec. Noise Model Calibration and Sec. Image Statistics: greyscale bars at
    50 cm and 2000 lux.
    """

    class Config(Settings):
        bars: int = setting(16, help="Number of bars.", ge=3, le=256)
        darkest: float = setting(0.0, help="Reflectance of the first bar.", ge=0, le=1)
        brightest: float = setting(0.9, help="Reflectance of the last bar.", gt=0, le=1)
        width_m: float = setting(0.13, help="Width of the target.", unit="m", gt=0)
        height_m: float = setting(0.10, help="Height of the target.", unit="m", gt=0)
        distance_m: float = setting(0.5, help="From the camera to the target.", unit="m", gt=0)
        frames: int = setting(1, help="Frames taken.", ge=1, le=1_000_000)

    def __init__(self, config: Config) -> None:
        self.config = config

    def episode(self, *, illumination_lux: float) -> Episode:
        """The target, and frames of it. `illumination_lux`: mean illuminance on the target [lux]."""
        config = self.config
        reflectances = np.linspace(config.darkest, config.brightest, config.bars)
        edges = np.linspace(-config.width_m / 2, config.width_m / 2, config.bars + 1)
        up_m = (-config.height_m / 2, config.height_m / 2)
        parts = [facing(config.distance_m, across, up_m, i) for i, across in enumerate(pairwise(edges))]
        world = bench_world(
            f"scene.grey-bars {config.bars} {config.darkest!r} {config.brightest!r}",
            parts,
            [matte(f"grey {reflectance:.3f}", reflectance) for reflectance in reflectances],
            illumination_lux=illumination_lux,
            distance_m=config.distance_m,
            width_m=config.width_m,
            height_m=config.height_m,
        )
        return standing(world, config.frames)
