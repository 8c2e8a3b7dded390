"""Light sources: glowing surfaces, lights that no surface shows, and what lies beyond the geometry."""

from __future__ import annotations

import math
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Light, World
from tacos_plugins.lighting import emitter_luminance_cd_m2
from tacos_plugins.renderers.mitsuba.materials import Description


def light_shape(mitsuba: ModuleType, light: Light) -> Description:
    black = {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.0, 0.0, 0.0]}}
    if light.normal is None:
        area_m2 = 4 * math.pi * light.radius_m**2
        shape: Description = {
            "type": "sphere",
            "center": light.position_m.astype(float).tolist(),
            "radius": float(light.radius_m),
        }
    else:
        shape = {"type": "rectangle", "to_world": mitsuba.ScalarTransform4f(_placed_square(light))}
        area_m2 = 4 * float(np.linalg.norm(np.cross(light.half_u_m, light.half_v_m)))
    emitter = area_emitter(emitter_luminance_cd_m2(light.flux_lm, area_m2), area_m2)
    return {**shape, "bsdf": black, "emitter": emitter}


def area_emitter(luminance_cd_m2: NDArray[Any], area_m2: float) -> Description:
    """A Lambertian emitter, tried as often as it sends out much; radiance stands for luminance [cd/m2]."""
    radiance = np.asarray(luminance_cd_m2, float)
    return {
        "type": "area",
        "radiance": {"type": "rgb", "value": radiance.tolist()},
        "sampling_weight": float(radiance.mean() * area_m2),
    }


def surroundings(mitsuba: ModuleType, world: World) -> Description | None:
    """Light from beyond the geometry, where there is any: a panorama as it is seen, or even light."""
    sky = world.sky_cd_m2
    if sky is not None:
        return _panorama(mitsuba, sky) if sky.any() else None
    if not world.ambient_cd_m2.any():
        return None
    radiance = {"type": "rgb", "value": world.ambient_cd_m2.astype(float).tolist()}
    return {"type": "constant", "radiance": radiance}


def _panorama(mitsuba: ModuleType, sky_cd_m2: NDArray[np.float32]) -> Description:
    """The panorama of a world (`World.sky_cd_m2`) as an environment map."""
    return {
        "type": "envmap",
        "bitmap": mitsuba.Bitmap(np.ascontiguousarray(_rows_from_pole_to_pole(sky_cd_m2)[:, ::-1])),
        "to_world": mitsuba.ScalarTransform4f(_WORLD_FROM_PANORAMA),
    }


_WORLD_FROM_PANORAMA = np.array([[0.0, 0, -1, 0], [-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]])
"""Mitsuba's panoramas have y up, begin at -z and go on by way of x: here +x, and, mirrored, by way of -y."""


def _rows_from_pole_to_pole(sky_cd_m2: NDArray[np.float32]) -> NDArray[np.float32]:
    """(2 H + 1, ...) rows of a panorama of H, for a reader whose first and last row are zenith and nadir.

    Mitsuba lays columns as a world has them, by their middles; it lays rows from pole to pole. Every second
    row here lies where one of the panorama's has its middle, and is that; those between are means.

    >>> _rows_from_pole_to_pole(np.float32([[1.0], [3.0]])).ravel().tolist()
    [1.0, 1.0, 2.0, 3.0, 3.0]
    """
    ends = np.concatenate([sky_cd_m2[:1], sky_cd_m2, sky_cd_m2[-1:]])
    rows = np.empty((2 * len(sky_cd_m2) + 1, *sky_cd_m2.shape[1:]), np.float32)
    rows[0::2] = (ends[:-1] + ends[1:]) / 2
    rows[1::2] = sky_cd_m2
    return rows


def _placed_square(light: Light) -> NDArray[np.float64]:
    """(4, 4) transform of the square -1..1 that faces +z onto a rectangular light [m]."""
    assert light.normal is not None
    u, v = light.half_u_m.astype(np.float64), light.half_v_m.astype(np.float64)
    if np.cross(u, v) @ light.normal < 0:
        u, v = v, u
    placed = np.eye(4)
    placed[:3, :4] = np.column_stack([u, v, light.normal, light.position_m])
    return placed
