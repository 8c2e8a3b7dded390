"""A file made ready to be walked in: labelled, its sides and its floor found, lit; read and baked once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Light, Material, MeshPart, Object, World, content_key
from tacos_plugins.kept_worlds.fingerprints import code_key
from tacos_plugins.kept_worlds.store import store_of_user
from tacos_plugins.lighting import LightTransport, photopic, scale_light
from tacos_plugins.lighting.occlusion import Occlusion
from tacos_plugins.lighting.refinement import refined
from tacos_worlds.imported.detail import simplified
from tacos_worlds.imported.finishes import materials_of
from tacos_worlds.imported.floor import Floor
from tacos_worlds.imported.front_sides import facing_the_eye
from tacos_worlds.imported.lamps import of_glowing, panel_luminance_cd_m2, placed, strongest
from tacos_worlds.imported.sky import Surroundings, even
from tacos_worlds.kit.models.model import Skin
from tacos_worlds.kit.models.normals import with_normals
from tacos_worlds.kit.models.patch import Patch
from tacos_worlds.kit.models.tints import tinted
from tacos_worlds.kit.world_key import world_key

PLANE_HEIGHT_M = 1.0
"""Height of the plane on which the illuminance is given [m]."""
_MOST_PLANE_POINTS = 2000
_MOST_SITES = 60_000
_RAYS = 64
_FINEST_MERGE_M = 0.08
_EDGE_M = 0.6
_UNLIT_LUX = 300.0
"""Of what was photographed with its light, where the study gives no illuminance: rooms one works in [lux]."""


@dataclass(frozen=True)
class Budget:
    triangles: int
    texture_memory_mb: float


@dataclass(frozen=True, eq=False)
class Sources:
    lights: tuple[Light, ...]
    emission_scale: float  # luminance for one unit of emission in the file [cd/m2]
    surroundings: Surroundings | None
    lamps: bool | None  # whether lamps are placed: always, or never, or (None) where nothing else shines


def geometry(patches: Sequence[Patch]) -> tuple[Occlusion, NDArray[np.int32]]:
    up = np.array([0.0, 0, 1])
    parts = tuple(
        _part(p if p.normals is not None else replace(p, normals=np.tile(up, (len(p.vertices_m), 1))))
        for p in patches
    )
    objects = (Object("background", "background"),) * (1 + max((p.object_id for p in patches), default=0))
    materials = (Material("any", np.ones(3, np.float32)),) * (1 + max((p.skin for p in patches), default=0))
    world = World("geometry", parts, materials, objects, ("background",))
    counts = [len(patch.triangles) for patch in patches]
    return Occlusion(world), np.repeat([p.object_id for p in patches], counts).astype(np.int32)


def lit_world(
    patches: Sequence[Patch],
    occlusion: Occlusion,
    skins: Sequence[Skin],
    objects: tuple[Object, ...],
    class_names: tuple[str, ...],
    floor: Floor,
    eye_m: float,
    sources: Sources,
    budget: Budget,
) -> tuple[World, float]:
    """The world, with the light its sources have, baked, and its mean illuminance 1 m above the floor [lux].

    `eye_m`: height of the agent's eye [m]. Raises ValueError where no light reaches the floor.
    """
    eyes = floor.points_m + np.array([0.0, 0.0, eye_m])
    faced = facing_the_eye(patches, occlusion, eyes)
    fewer = simplified(faced, eyes, budget.triangles)
    lights = [*sources.lights]
    for patch in fewer:
        emission = skins[patch.skin].emission * sources.emission_scale
        if emission.any():
            lights += of_glowing(patch, emission)
    photographed = all(skins[patch.skin].unlit for patch in fewer)
    lit = photographed or bool(lights) or sources.surroundings is not None
    surroundings = sources.surroundings
    all_skins, panels = list(skins), list[Patch]()
    if sources.lamps or (sources.lamps is None and not lit):
        lamps, panels = placed(floor)
        lights += lamps
        panels = [replace(panel, skin=len(all_skins)) for panel in panels]
        glow = panel_luminance_cd_m2() / max(sources.emission_scale, 1e-12)
        all_skins.append(Skin("placed lamp", np.full(3, 0.8), emission=glow))
        if not lamps and surroundings is None and not lit:
            surroundings = even(1.0)
    fewer, all_skins, atlases = tinted(fewer, all_skins)
    parts = tuple(_part(with_normals(patch)) for patch in [*fewer, *panels])
    world = World(
        key="unlit",
        parts=parts,
        materials=materials_of(
            all_skins, atlases, memory_mb=budget.texture_memory_mb, emission_scale=sources.emission_scale
        ),
        objects=objects,
        class_names=class_names,
        lights=tuple(strongest(lights)),
        ambient_cd_m2=np.zeros(3, np.float32)
        if surroundings is None
        else surroundings.mean.astype(np.float32),
        sky_cd_m2=None if surroundings is None else surroundings.panorama,
    )
    return _baked(world, floor)


def at_illuminance(world: World, lux: float, illumination_lux: float | None) -> World:
    """The world with its light scaled from `lux` to an illuminance; as it is where that is None [lux]."""
    if illumination_lux is None:
        return world
    factor = illumination_lux / lux
    scaled = scale_light(world, factor, key=f"{world.key}-{illumination_lux!r}")
    return replace(scaled, unscaled=world, light_factor=factor)


def _baked(world: World, floor: Floor) -> tuple[World, float]:
    """The world with indirect light, and the mean illuminance on the plane [lux]; kept on disk."""
    # Light is kept at vertices, of which a wall of two triangles has too few.
    world = refined(world, _longest_edge_m(world))
    key, plane_m = world_key("imported", world), _plane_m(floor)

    def made() -> tuple[tuple[NDArray[np.float32], ...], float]:
        unlit = [world.materials[part.material].unlit for part in world.parts]
        if all(unlit):
            return tuple(np.full_like(part.vertices_m, _UNLIT_LUX) for part in world.parts), _UNLIT_LUX
        transport = _transport(world)
        up = np.tile(np.array([0, 0, 1], np.float32), (len(plane_m), 1))
        reached = transport.direct_lux(plane_m, up) + transport.indirect_lux(plane_m, up)
        lux = float(photopic(reached).mean())
        around = zip(transport.vertex_indirect_lux(), unlit, strict=True)
        return tuple(np.full_like(each, lux) if even else each for each, even in around), lux

    store, code = store_of_user(), code_key(Budget)
    if store is None or code is None:
        indirect, lux = made()
    else:
        indirect, lux = store.get(content_key("imported light", key, plane_m, code), made, ())
    if not lux > 0:
        raise ValueError("no light reaches the floor")
    return replace(world, indirect_lux=indirect, key=key), lux


def _transport(world: World) -> LightTransport:
    """Light as fine as its number of places allows: a large world is lit more coarsely."""
    return LightTransport(
        world,
        rays=_RAYS,
        merge_m=max(_FINEST_MERGE_M, _spacing_m(world)),
        longest_edge_m=_longest_edge_m(world),
    )


def _longest_edge_m(world: World) -> float:
    return max(_EDGE_M, 4 * _spacing_m(world))


def _spacing_m(world: World) -> float:
    """Distance at which places of light cover all surfaces [m]."""
    corners = (part.vertices_m[part.triangles].astype(np.float64) for part in world.parts)
    doubled = (np.cross(c[:, 1] - c[:, 0], c[:, 2] - c[:, 0]) for c in corners)
    area_m2 = sum(float(np.linalg.norm(cross, axis=1).sum()) / 2 for cross in doubled)
    return float((area_m2 / _MOST_SITES) ** 0.5)


def _plane_m(floor: Floor) -> NDArray[np.float32]:
    """(N, 3) points of the plane on which the illuminance is given [m]."""
    chosen = np.linspace(0, len(floor.points_m) - 1, min(len(floor.points_m), _MOST_PLANE_POINTS)).astype(int)
    return (floor.points_m[chosen] + np.array([0, 0, PLANE_HEIGHT_M])).astype(np.float32)


def _part(patch: Patch) -> MeshPart:
    assert patch.normals is not None
    uv = np.zeros((len(patch.vertices_m), 2)) if patch.uv is None else patch.uv
    return MeshPart(
        vertices_m=patch.vertices_m.astype(np.float32),
        normals=patch.normals.astype(np.float32),
        uv_m=uv.astype(np.float32),
        triangles=patch.triangles.astype(np.int32),
        material=max(patch.skin, 0),
        object_id=patch.object_id,
    )
