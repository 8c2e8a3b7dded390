"""Lamps that a world holds twice: its lights send the flux out, surfaces that glow show the lamps.

A rasterizer lights by the former and draws the latter. Where light is traced, a glowing surface does both, so
a light that one shows is left out: to count both would light the world twice.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Light, World

_BESIDE_M = 0.05
"""A glowing surface this close to a light is that light's [m]."""


def bare_lights(world: World) -> list[Light]:
    """The lights that no glowing surface shows."""
    glowing = [
        part.vertices_m[part.triangles].mean(axis=1)
        for part in world.parts
        if world.materials[part.material].emission_cd_m2.any()
    ]
    centres_m = np.concatenate([np.zeros((0, 3), np.float32), *glowing])
    return [light for light in world.lights if not _inside(light, centres_m).any()]


def _inside(light: Light, point_m: NDArray[np.float32]) -> NDArray[np.bool_]:
    """(N,) whether (N, 3) points lie on a light, or hardly off it [m]."""
    offset = point_m - light.position_m
    if light.normal is None:
        return np.linalg.norm(offset, axis=1) <= light.radius_m + _BESIDE_M
    inside = np.abs(offset @ light.normal) <= _BESIDE_M
    for half in (light.half_u_m, light.half_v_m):
        length = float(np.linalg.norm(half))
        inside &= np.abs(offset @ half) / max(length, 1e-9) <= length + _BESIDE_M
    return inside
