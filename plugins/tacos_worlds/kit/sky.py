"""Sun and sky."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Light
from tacos_plugins.lighting import photopic, white_at
from tacos_worlds.kit.textures.noise import fractal, smoothstep

SUN_DISTANCE_M = 10_000.0
"""Far enough for parallel rays across the town, near enough for float32 rays [m]."""
SUN_RADIUS_DEG = 0.2666
"""Half the sun's apparent diameter [deg]."""
_ROWS = 256
_SUN_K = 5500.0


@dataclass(frozen=True, eq=False)
class Daylight:
    sun: Light | None  # the sun; None once it is down
    ambient_cd_m2: NDArray[np.float32]
    """(3,) mean luminance of the sky, weighted by the cosine from the zenith [cd/m2]."""
    sky_cd_m2: NDArray[np.float32]  # (H, 2 H, 3) as `World.sky_cd_m2` [cd/m2]


def draw_daylight(
    rng: np.random.Generator, *, elevation_deg: float, sun_share: float, clouds: float
) -> Daylight:
    """Daylight from a random side, which gives an open, level surface 1 lux.

    `sun_share`: share of the light on a level surface that comes straight from the sun [1]. `clouds`: Cover,
    from 0 for a clear sky to 1 [1].
    """
    azimuth, elevation = rng.uniform(0, 2 * math.pi), math.radians(elevation_deg)
    towards = np.array(
        [
            math.cos(elevation) * math.cos(azimuth),
            math.cos(elevation) * math.sin(azimuth),
            math.sin(elevation),
        ]
    )
    # A sphere of flux F gives a surface that faces it F / (4 pi d^2).
    flux = sun_share / math.sin(elevation) * 4 * math.pi * SUN_DISTANCE_M**2
    sun = Light(
        position_m=(SUN_DISTANCE_M * towards).astype(np.float32),
        flux_lm=(flux * white_at(_SUN_K)).astype(np.float32),
        radius_m=SUN_DISTANCE_M * math.tan(math.radians(SUN_RADIUS_DEG)),
    )
    shape = _sky(rng, towards, clouds)
    mean = cosine_mean(shape)
    factor = (1 - sun_share) / math.pi / float(photopic(mean))
    return Daylight(sun, (mean * factor).astype(np.float32), (shape * factor).astype(np.float32))


def cosine_mean(sky: NDArray[np.floating]) -> NDArray[np.float64]:
    """(3,) mean of the upper half of a panorama, weighted by the cosine from the zenith."""
    rows = len(sky)
    zenith_rad = (np.arange(rows) + 0.5) / rows * math.pi
    weight = np.clip(np.cos(zenith_rad), 0, None) * np.sin(zenith_rad)
    return np.asarray((sky.mean(axis=1) * weight[:, None]).sum(axis=0) / weight.sum())


def _sky(rng: np.random.Generator, sun: NDArray[np.float64], clouds: float) -> NDArray[np.float64]:
    """(H, 2 H, 3) relative luminance: blue above, pale at the horizon, brighter around the sun, clouds."""
    zenith = ((np.arange(_ROWS) + 0.5) / _ROWS * math.pi)[:, None]
    azimuth = ((np.arange(2 * _ROWS) + 0.5) / _ROWS * math.pi)[None, :]
    up = np.broadcast_to(np.cos(zenith), (_ROWS, 2 * _ROWS))
    x, y = np.sin(zenith) * np.cos(azimuth), np.sin(zenith) * np.sin(azimuth)
    height = np.clip(up, 0, 1)[..., None] ** 0.55
    clear = (1 - height) * np.array([0.82, 0.92, 1.02]) + height * np.array([0.22, 0.42, 0.85])
    angle = np.arccos(np.clip(x * sun[0] + y * sun[1] + up * sun[2], -1, 1))
    glow = 1.1 * np.exp(-angle / 0.16) + 0.35 * np.exp(-((angle / 0.7) ** 2))
    clear = clear + glow[..., None] * np.array([1.0, 0.97, 0.90])

    # Clouds lie on a plane above, so that they crowd towards the horizon.
    size = 512
    noise = fractal(rng, size, exponent=1.35, lowest=2)
    lit = fractal(rng, size, exponent=1.2, lowest=4)
    scale = size / 7.0 / np.maximum(up, 0.06)
    u, v = (np.rint(c * scale).astype(int) % size for c in (x, y))
    threshold = 1.9 - 2.6 * clouds
    cover = smoothstep(noise[v, u], threshold, threshold + 1.1) * smoothstep(up, 0.01, 0.12)
    cloud = (1.25 + 0.14 * lit[v, u] - 0.22 * cover)[..., None] * np.array([1.0, 1.0, 1.01])
    sky = clear + (cloud - clear) * (0.92 * cover)[..., None]
    below = np.broadcast_to(np.array([0.42, 0.42, 0.40]), sky.shape)
    return np.where(up[..., None] >= 0, sky, below)
