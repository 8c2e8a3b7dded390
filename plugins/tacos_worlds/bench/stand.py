"""The bench itself: flat targets that face the camera, what lights them, an agent that stands still.

The agent's eye is at the origin and looks along x; the target lies in the plane x = distance. Beyond it there
is nothing, and nothing reflects light but the target, as in a dark room. A panel above the camera lights it,
or a tent all around, which is even.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Episode, Light, Material, MeshPart, Object, Trajectory, World
from tacos_plugins.lighting.calibration import scale_light
from tacos_plugins.lighting.emitters import photopic
from tacos_plugins.lighting.transport import LightTransport

PANEL_DISTANCE_M = 0.8
"""From the middle of the target to that of the panel (paper, supplement, Image Statistics) [m]."""
PANEL_ELEVATION_DEG = 25.0
"""Height of the panel above the axis of the camera, seen from the target [deg]."""
PANEL_HALF_EDGE_M = 0.15
FRAME_INTERVAL_S = 0.1

SITE_M = 0.02
"""Corners of surfaces nearer than this receive the same reflected light [m]."""

BACKGROUND = Object("background", "background")
TARGET = Object("target", "target")


def matte(name: str, reflectance: float) -> Material:
    return Material(name, np.full(3, reflectance, np.float32), roughness=1.0)


def facing(
    distance_m: float,
    across_m: tuple[float, float],
    up_m: tuple[float, float],
    material: int = 0,
    object_id: int = 1,
) -> MeshPart:
    """A rectangle in the plane x = distance that faces the camera.

    `across_m`: its left and right edge as the camera sees them, positive to the right [m]. `up_m`: its lower
    and upper edge above the axis [m].
    """
    (left_m, right_m), (bottom_m, top_m) = across_m, up_m
    corners = [
        (distance_m, -left_m, bottom_m),
        (distance_m, -left_m, top_m),
        (distance_m, -right_m, top_m),
        (distance_m, -right_m, bottom_m),
    ]
    vertices = np.array(corners, np.float32)
    return MeshPart(
        vertices_m=vertices,
        normals=np.tile(np.array([-1, 0, 0], np.float32), (4, 1)),
        uv_m=vertices[:, 1:],
        triangles=np.array([[0, 1, 2], [0, 2, 3]], np.int32),
        material=material,
        object_id=object_id,
    )


def square(distance_m: float, half_m: float) -> MeshPart:
    """A square about the axis that faces the camera; `half_m`: half its edge [m]."""
    return facing(distance_m, (-half_m, half_m), (-half_m, half_m))


def panel(distance_m: float) -> Light:
    elevation = math.radians(PANEL_ELEVATION_DEG)
    towards = np.array([math.cos(elevation), 0.0, -math.sin(elevation)])
    up = np.array([math.sin(elevation), 0.0, math.cos(elevation)])
    return Light(
        position_m=(np.array([distance_m, 0.0, 0.0]) - PANEL_DISTANCE_M * towards).astype(np.float32),
        flux_lm=np.full(3, 1000.0, np.float32),
        normal=towards.astype(np.float32),
        half_u_m=np.array([0.0, PANEL_HALF_EDGE_M, 0.0], np.float32),
        half_v_m=(PANEL_HALF_EDGE_M * up).astype(np.float32),
    )


def bench_world(
    key: str,
    parts: Sequence[MeshPart],
    materials: Sequence[Material],
    *,
    illumination_lux: float,
    distance_m: float,
    width_m: float,
    height_m: float,
    reflections: bool = False,
) -> World:
    """A lit bench.

    - `key`: what makes the target what it is; light and distance are added to it.
    - `illumination_lux`: mean illuminance on the target itself, as a meter laid on it shows [lux].
    - `reflections`: true if light that comes over other surfaces is worked out too. A flat target alone
      receives none.
    """
    key = f"{key}; {distance_m!r} m, {width_m!r} x {height_m!r} m"
    world = World(
        key=key,
        parts=tuple(parts),
        materials=tuple(materials),
        objects=(BACKGROUND, TARGET),
        class_names=("background", "target"),
        lights=(panel(distance_m),),
        indirect_lux=tuple(np.zeros((len(part.vertices_m), 3), np.float32) for part in parts),
    )
    points = _points(distance_m, width_m, height_m)
    towards_camera = np.tile(np.array([-1, 0, 0], np.float32), (len(points), 1))
    transport = LightTransport(world, merge_m=SITE_M)
    found_lux = float(photopic(transport.direct_lux(points, towards_camera)).mean())
    if reflections:
        world = replace(world, indirect_lux=transport.vertex_indirect_lux())
    return scale_light(world, illumination_lux / found_lux, key=f"{key}; {illumination_lux!r} lux")


def tent_world(
    key: str,
    parts: Sequence[MeshPart],
    materials: Sequence[Material],
    *,
    illumination_lux: float,
    objects: Sequence[Object] = (TARGET,),
) -> World:
    """A target in a light tent: light from all sides, the same on every surface, and no shadow.

    - `key`: what makes the target what it is; the light is added to it.
    - `illumination_lux`: illuminance on every surface [lux].
    - `objects`: the objects that parts belong to, from id 1 on.
    """
    return World(
        key=f"{key}; tent of {illumination_lux!r} lux",
        parts=tuple(parts),
        materials=tuple(materials),
        objects=(BACKGROUND, *objects),
        class_names=tuple(dict.fromkeys(thing.class_name for thing in (BACKGROUND, *objects))),
        indirect_lux=tuple(np.full((len(p.vertices_m), 3), illumination_lux, np.float32) for p in parts),
    )


def turned(
    part: MeshPart,
    distance_m: float,
    *,
    right_m: float = 0.0,
    up_m: float = 0.0,
    tilt_deg: float = 0.0,
    turn_deg: float = 0.0,
) -> MeshPart:
    """A part of a target, turned with it about the target's middle.

    - `right_m`, `up_m`: the middle, off the axis [m].
    - `tilt_deg`: about the horizontal axis; above 0 the upper edge goes back [deg].
    - `turn_deg`: about the vertical axis; above 0 the right edge goes back [deg].
    """
    tilt, turn = math.radians(tilt_deg), math.radians(turn_deg)
    about_y = np.array([[math.cos(tilt), 0, math.sin(tilt)], [0, 1, 0], [-math.sin(tilt), 0, math.cos(tilt)]])
    about_z = np.array([[math.cos(turn), -math.sin(turn), 0], [math.sin(turn), math.cos(turn), 0], [0, 0, 1]])
    rotation = (about_z @ about_y).T.astype(np.float32)
    middle = np.array([distance_m, -right_m, up_m], np.float32)
    return replace(
        part, vertices_m=(part.vertices_m - middle) @ rotation + middle, normals=part.normals @ rotation
    )


def standing(world: World, frames: int) -> Episode:
    """Frames a tenth of a second apart from a place that does not change."""
    time_s = np.arange(frames, dtype=np.float64) * FRAME_INTERVAL_S
    poses = np.tile(np.eye(4), (2, 1, 1))
    trajectory = Trajectory(np.array([0.0, frames * FRAME_INTERVAL_S]), poses)
    return Episode(world, trajectory, time_s, np.zeros(frames, np.int32))


def _points(distance_m: float, width_m: float, height_m: float, count: int = 24) -> NDArray[np.float32]:
    """(count^2, 3) points spread evenly over a target, a little in front of it [m]."""
    middle = (np.arange(count) + 0.5) / count - 0.5
    y, z = np.meshgrid(middle * width_m, middle * height_m)
    x = np.full(y.size, distance_m - 1e-4)
    return np.stack([x, y.ravel(), z.ravel()], axis=1).astype(np.float32)
