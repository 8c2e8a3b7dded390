"""A world as Mitsuba sees it, and the truth behind its pixels."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework.camera.geometry import pixel_rays
from tacos_framework.values import Camera, Material, MeshPart, World
from tacos_plugins.lighting.occlusion import Occlusion
from tacos_plugins.renderers.mitsuba.light_sources import (
    area_emitter,
    bare_lights,
    light_shape,
    surroundings,
)
from tacos_plugins.renderers.mitsuba.materials import bsdf


class TracedWorld:
    """One world, translated.

    Parameters
    ----------
    mitsuba
        The module, set to the variant to compute with.
    world
        The world. Its `indirect_lux` is not used: reflections are traced.

    Attributes
    ----------
    scene
        The `mitsuba.Scene`.
    """

    def __init__(self, mitsuba: ModuleType, world: World):
        self.scene = mitsuba.load_dict(scene_description(mitsuba, world))
        self._occlusion = Occlusion(world)
        counts = [len(part.triangles) for part in world.parts]
        self._object_of_triangle = np.repeat([part.object_id for part in world.parts], counts).astype(
            np.int32
        )

    def truth(
        self, camera: Camera, world_from_camera: NDArray[np.float64], near_m: float
    ) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
        """(H, W) depth [m] and (H, W) object ids at pixel centres.

        One ray each: Mitsuba would average over the pixel, and a mean of depths or ids is neither.
        """
        directions = pixel_rays(camera).reshape(-1, 3) @ world_from_camera[:3, :3].T  # of depth 1
        origins = (world_from_camera[:3, 3] + near_m * directions).astype(np.float32)
        hits = self._occlusion.first_hits(origins, directions.astype(np.float32))
        seen = hits.triangle >= 0
        object_id = np.zeros(len(seen), np.int32)
        object_id[seen] = self._object_of_triangle[hits.triangle[seen]]
        shape = (camera.height_px, camera.width_px)
        return (hits.distance_m + np.float32(near_m)).reshape(shape), object_id.reshape(shape)


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
    if (beyond := surroundings(world)) is not None:
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
