"""From pieces to a `World`: materials, labels, light, and the content key."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Object, World
from tacos_plugins.lighting import with_illuminance
from tacos_worlds.indoor.building import Building
from tacos_worlds.kit.class_names import CLASS_NAMES
from tacos_worlds.kit.finishes import Finish, TextureLibrary, materials_of
from tacos_worlds.kit.mesh import Mesh, merged
from tacos_worlds.kit.piece import BACKGROUND, Piece
from tacos_worlds.kit.world_key import world_key

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
            parts.append(merged(meshes).part(material, object_id))
    world = World(
        key="unlit",
        parts=tuple(parts),
        materials=materials_of(finishes, library, images),
        objects=tuple(objects),
        class_names=CLASS_NAMES,
        lights=tuple(light for thing in [*unlabelled, *things] for light in thing.lights),
    )
    key = world_key("indoor", world, illumination_lux)
    return with_illuminance(world, illumination_lux, measuring_plane(building), key=key)


def _named(things: Sequence[Piece]) -> list[Object]:
    count: dict[str, int] = {}
    named = []
    for thing in things:
        number = count[thing.class_name] = count.get(thing.class_name, 0) + 1
        named.append(Object(f"{thing.class_name} {number}", thing.class_name))
    return named


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
