"""The key of a world follows from all that decides how it looks, and from nothing else."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tacos_framework.values import Light, Material, MeshPart, Object, World
from tacos_worlds.kit.world_key import world_key

GREY = np.full(3, 0.5, np.float32)
IMAGE = np.zeros((2, 2, 3), np.uint8)
PART = MeshPart(
    vertices_m=np.eye(3, dtype=np.float32),
    normals=np.eye(3, dtype=np.float32),
    uv_m=np.zeros((3, 2), np.float32),
    triangles=np.array([[0, 1, 2]], np.int32),
    material=0,
    object_id=0,
)
WORLD = World(
    key="unlit",
    parts=(PART,),
    materials=(Material("wall", GREY), Material("door", GREY, texture=IMAGE)),
    objects=(Object("background", "background"),),
    class_names=("background",),
    lights=(Light(np.zeros(3, np.float32), GREY),),
)


def with_part(**changed) -> World:
    return replace(WORLD, parts=(replace(PART, **changed),))


def with_material(number: int, **changed) -> World:
    materials = list(WORLD.materials)
    materials[number] = replace(materials[number], **changed)
    return replace(WORLD, materials=tuple(materials))


def with_light(**changed) -> World:
    return replace(WORLD, lights=(replace(WORLD.lights[0], **changed),))


OTHERS = {
    "vertices": with_part(vertices_m=2 * PART.vertices_m),
    "light detail": with_part(light_detail=0.5),
    "material": with_part(material=1),
    "texture of the second material": with_material(1, texture=IMAGE + 1),
    "normal map": with_material(1, normal_map=IMAGE),
    "roughness": with_material(0, roughness=0.1),
    "where a lamp shines": with_light(normal=np.array([0, 0, 1], np.float32)),
    "its size": with_light(radius_m=0.5),
    "surroundings": replace(WORLD, ambient_cd_m2=GREY),
    "sky": replace(WORLD, sky_cd_m2=np.ones((1, 2, 3), np.float32)),
    "what moves": replace(WORLD, objects=(Object("background", "background", moves=True),)),
}


@pytest.mark.parametrize("other", OTHERS.values(), ids=OTHERS)
def test_whatever_is_seen_or_gives_light_is_in_the_key(other: World) -> None:
    assert world_key("w", other) != world_key("w", WORLD)


def test_equal_worlds_have_one_key_and_other_illuminance_another() -> None:
    same = replace(WORLD, key="lit", indirect_lux=(np.ones((3, 3), np.float32),))
    assert world_key("w", same) == world_key("w", WORLD)
    assert world_key("w", WORLD, 20.0) != world_key("w", WORLD, 21.0)
