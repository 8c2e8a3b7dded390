"""The transform `transform.place-tags`: markers hung on the walls of any world."""

from __future__ import annotations

import hashlib
from dataclasses import replace
from itertools import islice
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_framework import Episode, Fault, Material, MeshPart, Object, Settings, UserError, World, setting
from tacos_plugins.tasks.fiducials.families import CLASS_NAME, Family, cells_of, dictionary_of
from tacos_worlds.tags.surfaces import Place, draw_places

TEXTURE_PX = 512


class PlaceTags:
    """Hangs fiducial markers on upright, even surfaces that are seen from the agent's way.

    It stands between a scene and its renderer, whatever the scene: rooms, a street, a building of your own.
    Each marker is an object of the class ``tag``, called by its family and number, so that tasks know what is
    true of it. One world, way and seed give the same places, always; on another way through the same world
    others may be chosen.

    Source: Olson 2011, "AprilTag: a robust and flexible visual fiducial system"; Garrido-Jurado et al. 2014,
    "Automatic generation and detection of highly reliable fiducial markers" (ArUco).
    """

    class Config(Settings):
        family: Family = setting("apriltag_36h11", help="Family of the markers, in OpenCV's drawing.")
        count: int = setting(12, help="Markers hung, at most as many as the family has.", ge=1, le=200)
        size_m: float = setting(
            0.16, help="Edge of a marker, black border included.", unit="m", gt=0.01, le=2.0
        )
        seed: int = setting(0, help="Seed of their places.", ge=0)

    def __init__(self, config: Config) -> None:
        self.config = config

    def transform(self, episode: Episode, *, memory: dict[str, Any]) -> Episode:
        if "world" not in memory:
            memory["world"] = self._hung(episode)
        return replace(episode, world=memory["world"])

    def _hung(self, episode: Episode) -> World:
        config, world = self.config, episode.world
        words = [*world.key.encode(), config.seed]
        sheet_m = config.size_m * (cells_of(config.family) + 2) / cells_of(config.family)
        most = min(config.count, len(dictionary_of(config.family).bytesList))
        places = list(islice(draw_places(np.random.default_rng(words), episode, sheet_m), most))
        if not places:
            what = f"no wall of this world takes a marker of {config.size_m:g} m"
            fix = "Give a smaller size_m, or a world with upright, even surfaces."
            raise UserError(Fault("transform.place-tags", what, "an even, upright surface in view", fix))
        return with_tags(world, places, config.family, sheet_m)


def with_tags(world: World, places: list[Place], family: str, sheet_m: float) -> World:
    """The world with a marker at each place, on a white sheet with an edge of `sheet_m` [m]."""
    corners = np.concatenate([place.corners_m(sheet_m) for place in places])
    where = hashlib.sha256(corners.tobytes()).hexdigest()
    first_material, first_object = len(world.materials), len(world.objects)
    lit = world.indirect_lux
    return replace(
        world,
        key=f"{world.key} with {family} at {where}",
        parts=(
            *world.parts,
            *(
                _sheet(place, sheet_m, first_material + number, first_object + number)
                for number, place in enumerate(places)
            ),
        ),
        materials=(*world.materials, *(_printed(family, number, sheet_m) for number in range(len(places)))),
        objects=(
            *world.objects,
            *(Object(f"{family} {number}", CLASS_NAME) for number in range(len(places))),
        ),
        class_names=tuple(dict.fromkeys((*world.class_names, CLASS_NAME))),
        indirect_lux=None if lit is None else (*lit, *(_light_at(world, place) for place in places)),
        unscaled=None,
        light_factor=1.0,
    )


def _sheet(place: Place, edge_m: float, material: int, object_id: int) -> MeshPart:
    return MeshPart(
        vertices_m=place.corners_m(edge_m).astype(np.float32),
        normals=np.tile(place.normal, (4, 1)).astype(np.float32),
        uv_m=np.array([[0, 0], [edge_m, 0], [edge_m, edge_m], [0, edge_m]], np.float32),
        triangles=np.array([[0, 1, 2], [0, 2, 3]], np.int32),
        material=material,
        object_id=object_id,
    )


def _printed(family: str, number: int, sheet_m: float) -> Material:
    dictionary, cells = dictionary_of(family), cells_of(family)
    marker = cv2.aruco.generateImageMarker(dictionary, number, cells)
    paper = np.pad(marker, 1, constant_values=255)
    large = cv2.resize(paper, (TEXTURE_PX, TEXTURE_PX), interpolation=cv2.INTER_NEAREST)
    ink = np.where(large > 127, 240, 25).astype(np.uint8)[::-1]
    return Material(
        name=f"{family} {number}",
        base_colour=np.ones(3, np.float32),
        texture=np.repeat(ink[..., None], 3, axis=2),
        texture_size_m=sheet_m,
        roughness=0.9,
    )


def _light_at(world: World, place: Place) -> NDArray[np.float32]:
    """(4, 3) indirect light of the wall behind, where a world brings its own [lux]."""
    assert world.indirect_lux is not None
    nearest = np.linalg.norm(world.parts[place.part].vertices_m - place.middle_m, axis=1).argmin()
    return np.tile(world.indirect_lux[place.part][nearest], (4, 1)).astype(np.float32)
