"""From pieces to a `World`: materials, labels, light, and the content key."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from tacos_framework.values import MeshPart, Object, World
from tacos_plugins.lighting import with_illuminance
from tacos_worlds.indoor.building import Building
from tacos_worlds.indoor.finishes import Finish, TextureLibrary, materials_of
from tacos_worlds.indoor.furnishing.catalogue import CLASS_NAMES
from tacos_worlds.indoor.mesh import Mesh, merged
from tacos_worlds.indoor.piece import BACKGROUND, Piece

PLANE_HEIGHT_M = 1.0
"""Height of the plane on which the illuminance is given [m]."""
_PLANE_STEP_M = 0.25


def assemble(
    building: Building,
    library: TextureLibrary,
    images: Mapping[int, NDArray[np.uint8]],
    illumination_lux: float,
) -> World:
    """The world of a building, lit to a mean illuminance on a plane 1 m above the floors of all rooms."""
    labelled = [m.piece for m in building.furniture if m.piece.class_name != BACKGROUND]
    unlabelled = [
        *building.background,
        *(m.piece for m in building.furniture if m.piece.class_name == BACKGROUND),
    ]
    things = [*building.thresholds, *labelled]
    objects = [Object("background", BACKGROUND), *_named(things)]
    finishes: dict[Finish, int] = {}
    parts = []
    for object_id, pieces in enumerate([unlabelled, *([thing] for thing in things)]):
        by_finish: dict[Finish, list[Mesh]] = {}
        for thing in pieces:
            for mesh, finish in thing.parts:
                by_finish.setdefault(finish, []).append(mesh)
        for finish, meshes in by_finish.items():
            material = finishes.setdefault(finish, len(finishes))
            parts.append(_part(merged(meshes), material, object_id))
    world = World(
        key="unlit",
        parts=tuple(parts),
        materials=materials_of(finishes, library, images),
        objects=tuple(objects),
        class_names=CLASS_NAMES,
        lights=tuple(light for thing in [*unlabelled, *things] for light in thing.lights),
    )
    key = content_key(world, illumination_lux)
    return with_illuminance(world, illumination_lux, measuring_plane(building), key=key)


def _named(things: Sequence[Piece]) -> list[Object]:
    count: dict[str, int] = {}
    named = []
    for thing in things:
        number = count[thing.class_name] = count.get(thing.class_name, 0) + 1
        named.append(Object(f"{thing.class_name} {number}", thing.class_name))
    return named


def _part(mesh: Mesh, material: int, object_id: int) -> MeshPart:
    return MeshPart(
        vertices_m=mesh.vertices_m.astype(np.float32),
        normals=mesh.normals.astype(np.float32),
        uv_m=mesh.uv_m.astype(np.float32),
        triangles=mesh.triangles.astype(np.int32),
        material=material,
        object_id=object_id,
    )


def measuring_plane(building: Building) -> NDArray[np.float32]:
    """(N, 3) points 1 m above the floors of all rooms, spread evenly [m]."""
    points = []
    for room in range(len(building.plan.cells)):
        clear = building.plan.clear(room)
        width, depth = clear.size
        columns, rows = round(width / _PLANE_STEP_M), round(depth / _PLANE_STEP_M)
        x = clear.x0 + (np.arange(columns) + 0.5) / columns * width
        y = clear.y0 + (np.arange(rows) + 0.5) / rows * depth
        grid_x, grid_y = np.meshgrid(x, y)
        points.append(np.column_stack([grid_x.ravel(), grid_y.ravel(), np.full(grid_x.size, PLANE_HEIGHT_M)]))
    return np.concatenate(points).astype(np.float32)


def content_key(world: World, illumination_lux: float) -> str:
    """A hash of everything that makes the world what it is."""
    digest = hashlib.blake2b(digest_size=16)
    digest.update(repr((world.objects, world.class_names, illumination_lux)).encode())
    for part in world.parts:
        digest.update(repr((part.material, part.object_id)).encode())
        for array in (part.vertices_m, part.normals, part.uv_m, part.triangles):
            digest.update(array.tobytes())
    seen: set[int] = set()
    for material in world.materials:
        digest.update(
            repr((material.name, material.texture_size_m, material.roughness, material.metallic)).encode()
        )
        digest.update(material.base_colour.tobytes() + material.emission_cd_m2.tobytes())
        if material.texture is not None and id(material.texture.base) not in seen:
            seen.add(id(material.texture.base))
            digest.update(material.texture.tobytes())
    for light in world.lights:
        digest.update(light.position_m.tobytes() + light.flux_lm.tobytes())
    return f"indoor-{digest.hexdigest()}"
