"""From settings to a place that can be walked in."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Fault, Light, Object, Trajectory, UserError, World, did_you_mean
from tacos_plugins.lighting import photopic
from tacos_plugins.lighting.occlusion import Occlusion
from tacos_worlds.imported.doubts import (
    clear_height_m,
    doubt_of_open_height,
    doubt_of_tilt,
    doubt_of_up,
    doubts_of_height,
)
from tacos_worlds.imported.floor import Agent, Floor, find_floor, walkable
from tacos_worlds.imported.formats.file_bytes import Unreadable
from tacos_worlds.imported.labels import Label, Rule, class_names, label_of, read_table, unused_rules
from tacos_worlds.imported.lamps import SUN_DISTANCE_M, of_file
from tacos_worlds.imported.place import Budget, Sources, geometry, lit_world
from tacos_worlds.imported.progress import Telling
from tacos_worlds.imported.reader import Read, area_along, read_world
from tacos_worlds.imported.recorded import read_recorded
from tacos_worlds.imported.settings import ImportedSettings
from tacos_worlds.imported.sky import Surroundings, read_surroundings
from tacos_worlds.imported.walkable_place import Place
from tacos_worlds.kit.models.patch import Patch, sound

log = logging.getLogger(__name__)

_LARGEST_TEXTURE_PX = 8192
_LAMPS = {"auto": None, "file": False, "lamps": True, "both": True}


@dataclass(frozen=True, eq=False)
class Survey:
    """A file that was read, labelled and found to have a floor, before it is lit."""

    read: Read
    sky: Surroundings | None
    patches: tuple[Patch, ...]
    occlusion: Occlusion
    object_of_triangle: NDArray[np.int32]
    objects: tuple[Object, ...]
    class_names: tuple[str, ...]
    agent: Agent
    floor: Floor
    recorded: Trajectory | None  # poses of the agent from a file, or None
    remarks: tuple[str, ...]
    """What is doubtful of the files, and what of them is not carried out, with its effect."""


def survey(config: ImportedSettings, telling: Telling | None = None) -> Survey:
    """Read, label, and look for the floor. Raises UserError with a fault for each thing that is wrong."""
    file = Path(config.file).expanduser()
    rules, faults = read_table(Path(config.labels).expanduser()) if config.labels else ([], [])
    sky, of_sky = _sky(config)
    try:
        read = read_world(
            file,
            up=config.up,
            metres_per_unit=config.metres_per_unit,
            leave_out=config.leave_out,
            most_px=_LARGEST_TEXTURE_PX,
            glass=config.glass,
        )
    except UserError as error:
        raise UserError([*error.faults, *faults, *of_sky]) from error
    recorded, remarks, of_path = _recorded(config, read)
    faults = [*faults, *of_sky, *of_path, *_idle(config, read, rules)]
    if faults:
        raise UserError(faults)
    if telling is not None:
        telling.read(read.model.triangle_count)
    labels = [label_of(surface, rules) for surface in read.model.surfaces]
    objects, ids, classes = _objects(labels, config.obstacles)
    patches = [sound(s, read.turn, i) for s, i in zip(read.model.surfaces, ids, strict=True)]
    patches = [patch for patch in patches if len(patch.triangles)]
    occlusion, object_of_triangle = geometry(patches)
    agent = Agent(config.radius_m, config.height_m, config.step_m)
    floor = _floor(config, occlusion, agent, read.origin_m)
    remarks += [f"{file.name}: {note}" for note in read.model.notes]
    doubts = [*_of_axes(config, read, occlusion, floor), *_of_obstacles(config, objects)]
    remarks += [f"{file.name}: {doubt}" for doubt in doubts]
    return Survey(
        read=read,
        sky=sky,
        patches=tuple(patches),
        occlusion=occlusion,
        object_of_triangle=object_of_triangle,
        objects=objects,
        class_names=classes,
        agent=agent,
        floor=floor,
        recorded=recorded,
        remarks=tuple(dict.fromkeys(remarks)),
    )


def prepare(config: ImportedSettings) -> Place:
    """Read, label, look for the floor, and light.

    Raises UserError with a fault for each thing that is wrong.
    """
    telling = Telling(Path(config.file).expanduser())
    found = survey(config, telling)
    for remark in found.remarks:
        log.warning("%s", remark)
    telling.done("geometry and floor")
    world, lux = _lit(config, found)
    telling.done("light")
    obstacles = tuple(
        i for i, thing in enumerate(found.objects) if i and thing.class_name in config.obstacles
    )
    return Place(
        world=world,
        lux=lux,
        floor=found.floor,
        agent=found.agent,
        occlusion=found.occlusion,
        object_of_triangle=found.object_of_triangle,
        obstacles=obstacles,
        recorded=found.recorded,
    )


def _sky(config: ImportedSettings) -> tuple[Surroundings | None, list[Fault]]:
    if not config.sky:
        return None, []
    try:
        sky = read_surroundings(Path(config.sky).expanduser(), config.sky_turn_deg)
    except UserError as error:
        return None, list(error.faults)
    except Unreadable as error:
        return None, [Fault(config.sky, f"cannot be used: {error}", "a panorama in .hdr or .exr")]
    if config.sky_lux is None:
        return sky, []
    given = float(photopic(np.pi * sky.mean)) + (0.0 if sky.sun is None else _level_lux(sky.sun))
    if not given > 0:
        return None, [Fault(config.sky, "is black above the horizon", "a panorama that gives light")]
    factor = config.sky_lux / given
    star = None if sky.sun is None else replace(sky.sun, flux_lm=sky.sun.flux_lm * np.float32(factor))
    return Surroundings(sky.panorama * np.float32(factor), sky.mean * factor, star), []


def _level_lux(star: Light) -> float:
    """Illuminance that a sun gives level ground [lux]."""
    height = max(float(star.position_m[2]) / SUN_DISTANCE_M, 0.0)
    return float(photopic(star.flux_lm)) / (4 * np.pi * SUN_DISTANCE_M**2) * height


def _recorded(config: ImportedSettings, read: Read) -> tuple[Trajectory | None, list[str], list[Fault]]:
    if not config.path:
        return None, [], []
    turn = read.turn if config.path_axes == "file" else np.eye(3)
    of_camera = config.path_of == "camera"
    try:
        path, doubts = read_recorded(Path(config.path).expanduser(), turn, read.origin_m, of_camera=of_camera)
        return path, doubts, []
    except UserError as error:
        return None, [], list(error.faults)
    except Unreadable as error:
        return (
            None,
            [],
            [
                Fault(
                    config.path,
                    f"cannot be used: {error}",
                    "poses as TUM, EuRoC, KITTI, COLMAP or NeRF write them",
                )
            ],
        )


def _idle(config: ImportedSettings, read: Read, rules: Sequence[Rule]) -> Iterator[Fault]:
    names = {name for surface in read.model.surfaces for name in surface.path}
    for rule in unused_rules(read.model.surfaces, rules):
        yield Fault(
            f"{config.labels}: {rule.pattern}",
            "matches no node of the file",
            remedy=did_you_mean(rule.pattern, list(names)[:500]),
        )


def _of_axes(config: ImportedSettings, read: Read, occlusion: Occlusion, floor: Floor) -> Iterator[str]:
    """Doubts about the unit and the vertical axis."""
    clear_m, height_m = clear_height_m(occlusion, floor.points_m), float(np.ptp(occlusion.vertices_m[:, 2]))
    yield from doubts_of_height(clear_m, config.metres_per_unit, config.camera_height_m)
    if clear_m is None and (doubt := doubt_of_open_height(height_m, config.metres_per_unit)):
        yield doubt
    area = area_along(read.model)
    of_up = config.up == "auto" and read.model.up
    if doubt := doubt_of_tilt(area) or (doubt_of_up(area, read.up) if of_up else None):
        yield doubt


def _of_obstacles(config: ImportedSettings, objects: Sequence[Object]) -> Iterator[str]:
    """A remark on classes of obstacles of which the file has none, where somebody asked for them.

    Raises UserError where frames are taken before obstacles alone, and there is none.
    """
    classes = {thing.class_name for thing in objects[1:]}
    missing = [name for name in config.obstacles if name not in classes]
    asked_for = config.obstacles != type(config).model_fields["obstacles"].default
    if not missing or (config.sampling == "walk" and not asked_for):
        return
    remedy = did_you_mean(missing[0], classes) if classes else "Nothing in the file is labelled: see labels."
    if config.sampling == "approaches" and len(missing) == len(config.obstacles):
        what = f"is approaches, but nothing in the file is of the class {' or '.join(missing)}"
        raise UserError(Fault(f"{config.file}: sampling", what, "things to step on", remedy))
    yield f"nothing in the file is of the class {' or '.join(missing)} (obstacles): {remedy}"


def _objects(
    labels: Sequence[Label], obstacles: Sequence[str]
) -> tuple[tuple[Object, ...], list[int], tuple[str, ...]]:
    things: dict[str, str] = {}
    for label in labels:
        if label.thing:
            things.setdefault(label.thing, label.class_name)
    ids = {thing: number for number, thing in enumerate(things, start=1)}
    objects = (Object("background", "background"), *(Object(thing, name) for thing, name in things.items()))
    classes = class_names([*labels, *(Label(name, name) for name in obstacles)])
    return objects, [ids.get(label.thing, 0) for label in labels], classes


def _floor(
    config: ImportedSettings, occlusion: Occlusion, agent: Agent, origin_m: NDArray[np.float64]
) -> Floor:
    inside = {"auto": None, "inside": True, "outside": False}[config.ground]
    everything = find_floor(occlusion, agent)
    start = None
    if config.start_m is not None:
        start = np.array((*config.start_m, np.nan)[:3]) - origin_m
        if np.isnan(start[2]) and len(everything.points_m):
            away = np.linalg.norm(everything.points_m[:, :2] - start[:2], axis=1)
            start[2] = everything.points_m[int(np.argmin(away)), 2]
    floor = walkable(everything, agent, inside=inside, start_m=start)
    if len(floor.points_m) >= 2:
        return floor
    lower, upper = occlusion.vertices_m.min(axis=0), occlusion.vertices_m.max(axis=0)
    extent = " x ".join(f"{length:.2f}" for length in upper - lower)
    raise UserError(
        Fault(
            config.file,
            f"has no floor an agent of {2 * agent.radius_m:g} m width and {agent.height_m:g} m height can "
            f"walk on ({len(everything.points_m)} places to stand in {extent} m)",
            "level surfaces with room above, z up after the settings up and metres_per_unit",
            "Check up and metres_per_unit by that extent; leave closed doors out (leave_out); or set ground, "
            "radius_m, step_m or height_m.",
        )
    )


def _lit(config: ImportedSettings, found: Survey) -> tuple[World, float]:
    model, sky = found.read.model, found.sky
    own = () if config.light == "lamps" else tuple(of_file(model.lights, found.read.turn))
    if sky is not None and sky.sun is not None:
        own = (*own, sky.sun)
    skins = model.skins
    if config.light == "lamps":
        skins = tuple(replace(skin, emission=np.zeros(3)) for skin in skins)
    sources = Sources(own, config.emission_cd_m2, sky, _LAMPS[config.light])
    eye_m = float(np.mean(config.camera_height_m))
    budget = Budget(config.triangles, config.texture_memory_mb)
    try:
        lit, lux = lit_world(
            found.patches,
            found.occlusion,
            skins,
            found.objects,
            found.class_names,
            found.floor,
            eye_m,
            sources,
            budget,
        )
    except ValueError as error:
        raise UserError(
            Fault(
                f"{config.file}: light",
                f"is {config.light}, but {error}",
                remedy="Give a sky, or light: both for lamps under the ceilings.",
            )
        ) from error
    return replace(lit, origin_m=found.read.origin_m, remarks=found.remarks), lux
