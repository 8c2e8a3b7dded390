"""A world and the pictures to take of it, as plain arrays that a process without this package can read."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Camera, Light, Material, World
from tacos_framework.camera import LINEAR_OF_SRGB_BYTE
from tacos_plugins.lighting import emitter_luminance_cd_m2
from tacos_plugins.renderers.traced.coat import sheen
from tacos_plugins.renderers.traced.lamps import bare_lights

_FAR_M = 1000.0
"""Spheres farther off are suns: parallel light [m]."""


def write_scene(folder: Path, world: World) -> None:
    """Write ``scene.json`` and ``scene.npz``.

    Radiance in Blender stands for luminance [cd/m2], irradiance for illuminance [lux].
    """
    arrays: dict[str, NDArray[Any]] = {}
    for index, part in enumerate(world.parts):
        size_m = np.float32(world.materials[part.material].texture_size_m)
        arrays[f"vertices_{index}"] = part.vertices_m
        arrays[f"normals_{index}"] = part.normals
        arrays[f"uv_{index}"] = part.uv_m / size_m
        arrays[f"triangles_{index}"] = part.triangles
    for index, material in enumerate(world.materials):
        if material.texture is not None:
            arrays[f"texture_{index}"] = (
                LINEAR_OF_SRGB_BYTE.astype(np.float32)[material.texture] * material.base_colour
            )
        if material.normal_map is not None:
            arrays[f"bumps_{index}"] = 0.5 + 0.5 * (material.normal_map.astype(np.float32) - 128) / 127
    if world.sky_cd_m2 is not None:
        arrays["sky"] = world.sky_cd_m2
    scene = {
        "parts": [{"material": part.material, "object": part.object_id} for part in world.parts],
        "materials": [_material(material) for material in world.materials],
        "lights": [_light(light) for light in bare_lights(world) if light.flux_lm.any()],
        "ambient": world.ambient_cd_m2.astype(float).tolist(),
    }
    np.savez(folder / "scene.npz", **arrays)  # type: ignore[arg-type]
    (folder / "scene.json").write_text(json.dumps(scene), encoding="utf-8")


def shot(
    camera: Camera,
    world_from_camera: NDArray[np.float64],
    moved: Mapping[int, NDArray[np.float64]],
    *,
    samples: int,
    seed: int,
) -> dict[str, Any]:
    """One picture: what to put into ``shots.json``."""
    return {
        "width": camera.width_px,
        "height": camera.height_px,
        "focal_px": camera.focal_length_px,
        "centre_px": [float(c) for c in camera.centre_px],
        "pose": world_from_camera.tolist(),
        "moved": {str(thing): matrix.tolist() for thing, matrix in moved.items()},
        "samples": samples,
        "seed": seed,
    }


def _material(material: Material) -> dict[str, Any]:
    return {
        "colour": material.base_colour.astype(float).tolist(),
        "roughness": float(material.roughness),
        "metallic": float(material.metallic),
        "coat": sheen(material),
        "emission": material.emission_cd_m2.astype(float).tolist(),
    }


def _light(light: Light) -> dict[str, Any]:
    at = light.position_m.astype(float)
    distance = float(np.linalg.norm(at))
    if light.normal is None and distance > _FAR_M:
        lux = light.flux_lm.astype(float) / (4 * np.pi * distance**2)
        angle = 2 * np.arctan2(light.radius_m, distance)
        return {
            "kind": "sun",
            "towards": (at / distance).tolist(),
            "lux": lux.tolist(),
            "angle": float(angle),
        }
    if light.normal is None:
        luminance = emitter_luminance_cd_m2(light.flux_lm, 4 * np.pi * light.radius_m**2)
        return {
            "kind": "sphere",
            "at": at.tolist(),
            "radius": float(light.radius_m),
            "luminance": luminance.tolist(),
        }
    u, v = light.half_u_m.astype(float), light.half_v_m.astype(float)
    area = 4 * float(np.linalg.norm(np.cross(u, v)))
    if np.cross(u, v) @ light.normal < 0:
        u, v = v, u
    corners = [at - u - v, at + u - v, at + u + v, at - u + v]
    luminance = emitter_luminance_cd_m2(light.flux_lm, area)
    return {"kind": "square", "corners": np.array(corners).tolist(), "luminance": luminance.tolist()}
