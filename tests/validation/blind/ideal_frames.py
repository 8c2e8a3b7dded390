"""Frames of an ideal camera, with and without an effect."""

from __future__ import annotations

import numpy as np

from tacos_validation.blind.generators import flat_scenes
from tacos_validation.blind.generators.camera import IdealCamera, IdealShot, Image
from tacos_validation.blind.generators.image_formation import take
from tacos_validation.blind.generators.injected_effect import InjectedEffect

MONO = IdealCamera(96, 72, focal_px=96.0, channels=1)
COLOUR = IdealCamera(96, 72, focal_px=96.0, channels=3)


def flat(camera: IdealCamera = MONO, level: float = 0.5, exposure_ms: float = 10.0) -> IdealShot:
    return IdealShot(camera, flat_scenes.even(camera, level), exposure_ms)


def scene(camera: IdealCamera = MONO, velocity: tuple[float, float] = (0.0, 0.0)) -> IdealShot:
    rng = np.random.default_rng(5)
    return IdealShot(camera, flat_scenes.natural(camera, rng), 10.0, velocity_px_s=velocity)


def frames(shot: IdealShot, *effects: InjectedEffect, count: int = 4, seed: int = 1) -> Image:
    return take(shot, effects, count, np.random.default_rng(seed), sensor_seed=3)


def difference(shot: IdealShot, *effects: InjectedEffect, count: int = 6) -> Image:
    return np.asarray((frames(shot, *effects, count=count) - frames(shot, count=count, seed=2)).mean(axis=0))
