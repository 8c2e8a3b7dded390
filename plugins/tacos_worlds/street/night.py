"""Light from above at dusk and by night, and what cars show then."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tacos_plugins.lighting import photopic, white_at
from tacos_worlds.kit.finishes import Finish
from tacos_worlds.kit.piece import Piece
from tacos_worlds.kit.sky import Daylight, cosine_mean
from tacos_worlds.kit.textures.noise import fractal, smoothstep
from tacos_worlds.street.finishes import HEADLIGHT, TAIL_LIGHT

SKY_LUX = {"dusk": 14.0, "night": 0.25}
"""Illuminance of open ground from the sky alone: civil twilight with the sun some 4 degrees down, and a night
sky over a lit town with a moon behind clouds; street lamps (`furniture.LAMP_LM`) give about ten [lux].

References
----------
Schlyter, P. (2017). Radiometry and photometry in astronomy, section 6 (illuminance at twilight and by night).
"""
_HEADLIGHT_CD_M2 = 9000.0
_TAIL_CD_M2 = 250.0
_ROWS = 256


def draw_dark_sky(rng: np.random.Generator, *, light: str, clouds: float) -> Daylight:
    """The sky without a sun. `clouds`: Cover, from 0 for a clear sky to 1 [1]."""
    shape = _sky(rng, dusk=light == "dusk", clouds=clouds)
    mean = cosine_mean(shape)
    factor = SKY_LUX[light] / math.pi / float(photopic(mean))
    return Daylight(None, (mean * factor).astype(np.float32), (shape * factor).astype(np.float32))


def with_lamps_on(car: Piece) -> Piece:
    """A car with its headlights and tail lights on: they are seen, but light nothing."""
    shown = {
        HEADLIGHT: _HEADLIGHT_CD_M2 * white_at(5000.0),
        TAIL_LIGHT: _TAIL_CD_M2 * np.array([2.6, 0.05, 0.02]),
    }
    return replace(
        car, parts=tuple((mesh, _glowing(finish, shown.get(finish))) for mesh, finish in car.parts)
    )


def _glowing(finish: Finish, emission: NDArray[np.float64] | None) -> Finish:
    if emission is None:
        return finish
    red, green, blue = emission.tolist()
    return replace(finish, emission_cd_m2=(red, green, blue))


def _sky(rng: np.random.Generator, *, dusk: bool, clouds: float) -> NDArray[np.float64]:
    """(H, 2 H, 3) relative luminance: an afterglow on one side, or the glow of the town along the horizon."""
    zenith = ((np.arange(_ROWS) + 0.5) / _ROWS * math.pi)[:, None]
    azimuth = ((np.arange(2 * _ROWS) + 0.5) / _ROWS * math.pi)[None, :]
    up = np.broadcast_to(np.cos(zenith), (_ROWS, 2 * _ROWS))
    height = np.clip(up, 0, 1)[..., None] ** 0.6
    if dusk:
        towards = (1 + np.cos(azimuth - rng.uniform(0, 2 * math.pi)))[..., None] / 2
        low = towards * np.array([1.5, 0.82, 0.42]) + (1 - towards) * np.array([0.36, 0.36, 0.50])
        clear = (1 - height) * low + height * np.array([0.13, 0.22, 0.48])
        cloud = np.array([0.42, 0.34, 0.40]) + 0.4 * towards * (1 - height) * np.array([1.0, 0.5, 0.3])
    else:
        clear = (1 - height) * np.array([0.62, 0.48, 0.36]) + height * np.array([0.10, 0.13, 0.21])
        cloud = np.broadcast_to(np.array([0.40, 0.34, 0.30]), clear.shape)
    size = 512
    noise = fractal(rng, size, exponent=1.35, lowest=2)
    scale = size / 7.0 / np.maximum(up, 0.06)
    x, y = np.sin(zenith) * np.cos(azimuth), np.sin(zenith) * np.sin(azimuth)
    u, v = (np.rint(c * scale).astype(int) % size for c in (x, y))
    threshold = 1.9 - 2.6 * clouds
    cover = (smoothstep(noise[v, u], threshold, threshold + 1.1) * smoothstep(up, 0.01, 0.12))[..., None]
    sky = clear + (cloud - clear) * (0.8 * cover)
    return np.where(up[..., None] >= 0, sky, 0.3 * np.broadcast_to(clear[_ROWS // 2 - 1], sky.shape))
