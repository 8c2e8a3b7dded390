"""From what stands in a town to a `World`: materials, labels, daylight, and the content key."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from tacos_framework import Light, Object, World
from tacos_plugins.lighting import LightTransport, photopic, scale_light
from tacos_worlds.kit.finishes import Finish, materials_of
from tacos_worlds.kit.mesh import Mesh, merged
from tacos_worlds.kit.sky import Daylight
from tacos_worlds.kit.world_key import world_key
from tacos_worlds.street.city import CARRIAGEWAY_M, PAVEMENT_M, Town
from tacos_worlds.street.finishes import StreetTextures
from tacos_worlds.street.streetscape import PlacedPiece

CLASS_NAMES = (
    "background",
    "road",
    "pavement",
    "building",
    "vegetation",
    "tree",
    "car",
    "footbridge",
    "lamp post",
    "sign",
    "traffic light",
    "bus shelter",
    "bench",
    "bin",
    "bollard",
    "planter",
    "advertisement",
    "person",
)
PLANE_HEIGHT_M = 1.0
"""Height of the plane on which the illuminance is given [m]."""
_PLANE_STEP_M = 4.0
_LIGHT_EDGE_M = 9.0
"""Daylight changes little within this outdoors [m]."""
_LIGHT_MERGE_M = 1.5
_LIGHT_RAYS = 32
_LAMPS_M, _MEASURED_M = 75.0, 40.0
"""How far from the agent's way lamps light the street, and how far the illuminance is measured [m]."""


def assemble(
    town: Town,
    placed: Sequence[PlacedPiece],
    textures: StreetTextures,
    daylight: Daylight,
    illumination_lux: float,
    way_m: NDArray[np.float64] | None = None,
) -> World:
    """The world of a town, lit to a mean illuminance 1 m above its inner streets.

    With `way_m`, (N, 2) places that the agent passes, only lamps near it light the street, and the mean is
    that of the streets there: each lamp has to be followed through the whole town.
    """
    finishes: dict[Finish, int] = {}
    objects, parts, count = [Object("background", "background")], [], dict.fromkeys(CLASS_NAMES, 0)
    for object_id, thing in enumerate(placed, start=1):
        name = thing.piece.class_name
        count[name] += 1
        objects.append(Object(f"{name} {count[name]}", name, moves=thing.moves))
        by_finish: dict[Finish, list[Mesh]] = {}
        for mesh, finish in thing.piece.parts:
            by_finish.setdefault(finish, []).append(mesh)
        for finish, meshes in by_finish.items():
            material = finishes.setdefault(finish, len(finishes))
            parts.append(merged(meshes).part(material, object_id, thing.light_detail))
    unlit = World(
        key="unlit",
        parts=tuple(parts),
        materials=materials_of(finishes, textures, {}),
        objects=tuple(objects),
        class_names=CLASS_NAMES,
        lights=(
            *(() if daylight.sun is None else (daylight.sun,)),
            *_lamps(placed, way_m),
        ),
        ambient_cd_m2=daylight.ambient_cd_m2,
        sky_cd_m2=daylight.sky_cd_m2,
    )
    plane = measuring_plane(town)
    if way_m is not None:
        plane = plane[cKDTree(way_m).query(plane[:, :2])[0] < _MEASURED_M]
    return _lit(unlit, illumination_lux, plane)


def _lamps(placed: Sequence[PlacedPiece], way_m: NDArray[np.float64] | None) -> list[Light]:
    lamps = [light for thing in placed for light in thing.piece.lights]
    if way_m is None or not lamps:
        return lamps
    places = np.array([lamp.position_m[:2] for lamp in lamps])
    near = np.flatnonzero(np.asarray(cKDTree(way_m).query(places)[0]) < _LAMPS_M)
    return [lamps[k] for k in near.tolist()]


def _lit(world: World, illumination_lux: float, plane_m: NDArray[np.float32]) -> World:
    """The world with indirect light baked, scaled to the illuminance."""
    transport = LightTransport(world, rays=_LIGHT_RAYS, merge_m=_LIGHT_MERGE_M, longest_edge_m=_LIGHT_EDGE_M)
    up = np.tile(np.array([0, 0, 1], np.float32), (len(plane_m), 1))
    reached = transport.direct_lux(plane_m, up) + transport.indirect_lux(plane_m, up)
    baked = replace(world, indirect_lux=transport.vertex_indirect_lux())
    factor = illumination_lux / float(photopic(reached).mean())
    return scale_light(baked, factor, key=world_key("street", world, illumination_lux))


def measuring_plane(town: Town) -> NDArray[np.float32]:
    """(N, 3) points 1 m above the inner streets, from house to house, spread evenly [m]."""
    middle, half = town.middle, CARRIAGEWAY_M / 2 + PAVEMENT_M
    across = np.arange(-half + 0.5, half, 2.0)
    points = []
    for y in town.street_y_m:
        x = np.arange(middle.x0, middle.x1, _PLANE_STEP_M)
        points.append(np.stack(np.meshgrid(x, y + across), axis=-1).reshape(-1, 2))
    for x0 in town.street_x_m:
        y_m = np.arange(middle.y0, middle.y1, _PLANE_STEP_M)
        points.append(np.stack(np.meshgrid(x0 + across, y_m), axis=-1).reshape(-1, 2))
    level = np.concatenate(points)
    return np.column_stack([level, np.full(len(level), PLANE_HEIGHT_M)]).astype(np.float32)
