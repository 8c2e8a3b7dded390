"""A world as Mitsuba sees it, and the truth behind its pixels."""

from __future__ import annotations

from functools import cached_property
from types import ModuleType
from typing import Any

import numpy as np

from tacos_framework import Material, MeshPart, World
from tacos_plugins.renderers.mitsuba.light_sources import area_emitter, light_shape, surroundings
from tacos_plugins.renderers.mitsuba.materials import bsdf
from tacos_plugins.renderers.traced.lamps import bare_lights
from tacos_plugins.renderers.traced.truth import TracedTruth


class TracedWorld:
    """One world, translated.

    - `mitsuba`: the module, set to the variant to compute with.
    - `world`: the world. Its `indirect_lux` is not used: reflections are traced.

    `scene`: the `mitsuba.Scene`.
    """

    def __init__(self, mitsuba: ModuleType, world: World):
        self.scene = mitsuba.load_dict(scene_description(mitsuba, world))
        self._world = world

    @cached_property
    def truth(self) -> TracedTruth:
        """Depth and object ids."""
        return TracedTruth(self._world)


def scene_description(mitsuba: ModuleType, world: World) -> dict[str, Any]:
    """The surfaces and light sources of a world, for `mitsuba.load_dict`."""
    bsdfs = [mitsuba.load_dict(bsdf(mitsuba, material)) for material in world.materials]
    scene: dict[str, Any] = {"type": "scene"}
    for index, part in enumerate(world.parts):
        if len(part.triangles):
            scene[f"part_{index}"] = _mesh(
                mitsuba, part, world.materials[part.material], bsdfs[part.material]
            )
    for index, light in enumerate(bare_lights(world)):
        scene[f"light_{index}"] = light_shape(mitsuba, light)
    if (beyond := surroundings(mitsuba, world)) is not None:
        scene["surroundings"] = beyond
    return scene


def _mesh(mitsuba: ModuleType, part: MeshPart, material: Material, surface: Any) -> Any:
    properties = mitsuba.Properties()
    properties["bsdf"] = surface
    if material.emission_cd_m2.any():
        properties["emitter"] = mitsuba.load_dict(area_emitter(material.emission_cd_m2, _area_m2(part)))
    mesh = mitsuba.Mesh(
        "part",
        vertex_count=len(part.vertices_m),
        face_count=len(part.triangles),
        has_vertex_normals=True,
        has_vertex_texcoords=True,
        props=properties,
    )
    values = mitsuba.traverse(mesh)
    values["vertex_positions"] = part.vertices_m.ravel()
    values["vertex_normals"] = part.normals.ravel()
    values["vertex_texcoords"] = (part.uv_m / np.float32(material.texture_size_m)).ravel()  # in tiles
    values["faces"] = part.triangles.astype(np.uint32).ravel()
    values.update()
    return mesh


def _area_m2(part: MeshPart) -> float:
    corners = part.vertices_m[part.triangles].astype(np.float64)
    doubled = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return float(np.linalg.norm(doubled, axis=1).sum()) / 2
