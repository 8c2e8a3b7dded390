"""What shines: glowing surfaces, lights that no surface shows, and what lies beyond the geometry."""

from __future__ import annotations

import math
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework.values import Light, World
from tacos_plugins.lighting import emitter_luminance_cd_m2
from tacos_plugins.renderers.mitsuba.materials import Description


def light_shape(mitsuba: ModuleType, light: Light) -> Description:
    """A black surface that sends out a light's flux."""
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


def surroundings(world: World) -> Description | None:
    """What lies beyond the geometry, where it shines at all."""
    if not world.ambient_cd_m2.any():
        return None
    radiance = {"type": "rgb", "value": world.ambient_cd_m2.astype(float).tolist()}
    return {"type": "constant", "radiance": radiance}


def _placed_square(light: Light) -> NDArray[np.float64]:
    """(4, 4) transform of the square -1..1 that faces +z onto a rectangular light [m]."""
    assert light.normal is not None
    u, v = light.half_u_m.astype(np.float64), light.half_v_m.astype(np.float64)
    if np.cross(u, v) @ light.normal < 0:
        u, v = v, u
    placed = np.eye(4)
    placed[:3, :4] = np.column_stack([u, v, light.normal, light.position_m])
    return placed
