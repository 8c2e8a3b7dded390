"""Worlds and episodes small enough to check by hand."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import count

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tacos_framework.testing.samples import sample_episode
from tacos_framework.values import (
    Camera,
    Capture,
    Episode,
    Light,
    Material,
    MeshPart,
    Mover,
    Object,
    Rig,
    Trajectory,
    View,
    World,
)

_keys = count()


def matte(reflectance: float = 1.0, **figures: object) -> Material:
    """A grey Lambertian material."""
    return Material("matte", np.full(3, reflectance), **{"roughness": 1.0, **figures})


def quad(
    centre_m: ArrayLike, half_u_m: ArrayLike, half_v_m: ArrayLike, material: int = 0, object_id: int = 0
) -> MeshPart:
    """A rectangle that faces along u x v."""
    centre, u, v = (np.asarray(each, np.float64) for each in (centre_m, half_u_m, half_v_m))
    corners = np.array([centre - u - v, centre + u - v, centre + u + v, centre - u + v])
    normal = np.cross(u, v) / np.linalg.norm(np.cross(u, v))
    lu, lv = np.linalg.norm(u), np.linalg.norm(v)
    uv = np.array([[-lu, -lv], [lu, -lv], [lu, lv], [-lu, lv]])
    return MeshPart(corners, np.tile(normal, (4, 1)), uv, [[0, 1, 2], [0, 2, 3]], material, object_id)


def disc(
    centre_m: ArrayLike, u: ArrayLike, v: ArrayLike, radius_m: float, material: int = 0, object_id: int = 0
) -> MeshPart:
    """A disc of 64 triangles spanned by unit vectors, facing along u x v."""
    centre, u, v = (np.asarray(each, np.float64) for each in (centre_m, u, v))
    turn = np.arange(64) / 64 * 2 * np.pi
    rim = centre + radius_m * (np.cos(turn)[:, None] * u + np.sin(turn)[:, None] * v)
    vertices = np.vstack([rim, centre])
    triangles = [[64, i, (i + 1) % 64] for i in range(64)]
    return MeshPart(
        vertices, np.tile(np.cross(u, v), (65, 1)), np.zeros((65, 2)), triangles, material, object_id
    )


def box(lower_m: ArrayLike, upper_m: ArrayLike, material: int = 0, object_id: int = 0) -> list[MeshPart]:
    """The six sides of a box, facing outwards; a room is a box of negative size, facing inwards."""
    lower, upper = np.asarray(lower_m, np.float64), np.asarray(upper_m, np.float64)
    centre, half = (lower + upper) / 2, (upper - lower) / 2
    sides = []
    for axis in range(3):
        for sign in (1.0, -1.0):
            u, v = np.zeros(3), np.zeros(3)
            u[(axis + 1) % 3] = half[(axis + 1) % 3]
            v[(axis + 2) % 3] = half[(axis + 2) % 3] * sign
            middle = centre.copy()
            middle[axis] += sign * half[axis]
            sides.append(quad(middle, u, v, material, object_id))
    return sides


def room(lower_m: ArrayLike, upper_m: ArrayLike, material: int = 0) -> list[MeshPart]:
    """Floor, ceiling and walls of a room, facing inwards."""
    inwards = []
    for side in box(lower_m, upper_m, material):
        inwards.append(
            MeshPart(side.vertices_m, -side.normals, side.uv_m, side.triangles[:, ::-1], material, 0)
        )
    return inwards


def world(
    parts: Sequence[MeshPart],
    materials: Sequence[Material] = (),
    lights: Sequence[Light] = (),
    *,
    indirect_lux: float | None = 0.0,
    ambient_cd_m2: float = 0.0,
) -> World:
    """A world with as many objects as its parts name, each time with a key of its own."""
    things = 1 + max((part.object_id for part in parts), default=0)
    indirect = None
    if indirect_lux is not None:
        indirect = tuple(np.full((len(part.vertices_m), 3), indirect_lux, np.float32) for part in parts)
    return World(
        key=f"small-{next(_keys)}",
        parts=tuple(parts),
        materials=tuple(materials) or (matte(),),
        objects=tuple(Object(f"thing {i}", "thing" if i else "background") for i in range(things)),
        class_names=("background", "thing"),
        lights=tuple(lights),
        indirect_lux=indirect,
        ambient_cd_m2=np.full(3, ambient_cd_m2),
    )


def panel(at_m: ArrayLike, half_m: float, flux_lm: ArrayLike) -> Light:
    """A square lamp that shines downwards; `flux_lm`: in all, or of each channel."""
    return Light(
        np.asarray(at_m, np.float64),
        np.ones(3) * flux_lm,
        normal=np.array([0, 0, -1.0]),
        half_u_m=np.array([half_m, 0, 0]),
        half_v_m=np.array([0, half_m, 0]),
    )


def pose(eye_m: ArrayLike, towards: ArrayLike = (1.0, 0.0, 0.0)) -> NDArray[np.float64]:
    """(4, 4) pose of an agent at a place, facing a direction, upright."""
    forward = np.asarray(towards, np.float64) / np.linalg.norm(towards)
    left = np.cross([0.0, 0.0, 1.0], forward)
    left /= np.linalg.norm(left)
    placed = np.eye(4)
    placed[:3, :3] = np.stack([forward, left, np.cross(forward, left)], axis=1)
    placed[:3, 3] = eye_m
    return placed


def standing(place: World, at: NDArray[np.float64] | None = None, frames: int = 1) -> Episode:
    """An agent that stays where it is."""
    poses = (pose((0.0, 0.0, 0.0)) if at is None else at)[None]
    return Episode(place, Trajectory([0.0], poses), np.arange(frames) * 0.1, np.zeros(frames))


def moving(place: World, start: NDArray[np.float64], end: NDArray[np.float64], frames: int = 1) -> Episode:
    """An agent that goes from pose to pose within a second; the frames lie around its middle."""
    times = 0.5 + 0.1 * (np.arange(frames) - (frames - 1) / 2)
    return Episode(place, Trajectory([0.0, 1.0], np.stack([start, end])), times, np.zeros(frames))


def camera(width_px: int = 64, height_px: int = 48, focal_px: float = 60.0, **more: object) -> Camera:
    """A camera with a focal length in pixels, level and straight ahead unless told otherwise."""
    from tacos_framework.camera.geometry import agent_from_camera

    more.setdefault("agent_from_camera", agent_from_camera((0.0, 0.0, 0.0), 0.0))
    more.setdefault("name", "camera")
    return Camera(
        width_px=width_px, height_px=height_px, pixel_um=2.0, focal_length_mm=focal_px * 2e-3, **more
    )


def rig(*cameras: Camera) -> Rig:
    return Rig(cameras)


def captured_light(camera: Camera, light_cd_m2: ArrayLike, frames: int) -> Capture:
    """Frames of light that reaches a camera: a level, or what broadcasts to (frames, H, W, 3)."""
    size = (frames, camera.height_px, camera.width_px)
    light = np.broadcast_to(np.asarray(light_cd_m2, np.float32), (*size, 3))
    poses = np.tile(np.eye(4), (frames, 1, 1))
    view = View(camera, poses, light.copy(), np.ones(size, np.float32), np.zeros(size, np.int32))
    return Capture(sample_episode(frames), (view,))


def moving_plate(frames: int = 3) -> Episode:
    """A bright plate at 10 m that moves to the right by 1 m a second, in front of a dark wall at 20 m."""
    plate = quad((10, 0, 2), (0, -0.5, 0), (0, 0, 0.5), 0, object_id=1)
    wall = quad((20, 0, 2), (0, -30, 0), (0, 0, 10), 1, object_id=0)
    bright, dark = matte(0.0, emission_cd_m2=np.full(3, 100.0)), matte(0.0)
    place = world([plate, wall], [bright, dark])
    place = replace(
        place, objects=(place.objects[0], Object("plate", place.objects[1].class_name, moves=True))
    )
    shifted = np.tile(np.eye(4), (2, 1, 1))
    shifted[1, 1, 3] = -10.0
    still = Trajectory([0.0], pose((0.0, 0.0, 2.0), (1.0, 0.0, 0.0))[None])
    mover = Mover(1, Trajectory([0.0, 10.0], shifted))
    return Episode(place, still, np.arange(frames) * 1.0, np.zeros(frames), movers=(mover,))
