"""Reflection probes: where they stand, the room around them, and what is seen there."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Camera, Light, World
from tacos_framework.camera import agent_from_camera, pixel_rays
from tacos_plugins.renderers.light.rays import RayTracer

FACE_PX = 128
"""Edge of each of the six views of a probe [px]."""

MOST_PROBES = 24
"""Most probes a world gets [1]."""

APART_M = 3.5
"""Probes that see each other stand at least this far apart [m]."""

_FACES = ((0.0, 0.0), (0.0, 90.0), (0.0, 180.0), (0.0, 270.0), (90.0, 0.0), (-90.0, 0.0))  # pitch, yaw [deg]
_BEYOND_M = 50.0  # stands for nothing in sight
_SUN_DISTANCE = 8.0  # lights farther off, in diagonals of the world, belong to no room
_ON_SURFACE_M = 0.05  # a light this close to a surface is that surface

FaceView = Callable[[Camera, NDArray[np.float64]], tuple[NDArray[np.float32], NDArray[np.float32]]]
"""Renders (H, W, 3) luminance [cd/m2] and (H, W) depth [m] for a camera and its pose."""


@dataclass(frozen=True, eq=False)
class Probe:
    """The light around one place."""

    position_m: NDArray[np.float64]
    """(3,) the place [m]."""
    lower_m: NDArray[np.float64]
    upper_m: NDArray[np.float64]
    """(3,) corners of a box like the room around it [m]."""
    faces_cd_m2: NDArray[np.float32]
    """(6, FACE_PX, FACE_PX, 3) float32 luminance [cd/m2]."""


def face_camera(edge_px: int = FACE_PX) -> Camera:
    return Camera("probe", edge_px, edge_px, pixel_um=1.0, focal_length_mm=edge_px / 2 * 1e-3)


def face_rotations() -> NDArray[np.float64]:
    """(6, 3, 3) world_from_camera rotations of the faces: +x, +y, -x, -y, up, down."""
    return np.stack([agent_from_camera((0, 0, 0), pitch, yaw)[:3, :3] for pitch, yaw in _FACES])


def probe_places(world: World, tracer: RayTracer) -> NDArray[np.float64]:
    """(P, 3) places for probes: half-way below lights, one per room as far as lights tell rooms apart [m]."""
    corners = np.concatenate([np.zeros((1, 3), np.float32)] + [part.vertices_m for part in world.parts])
    middle = (corners.min(axis=0) + corners.max(axis=0)).astype(np.float64) / 2
    far_m = _SUN_DISTANCE * float(np.linalg.norm(np.ptp(corners, axis=0)))
    wanted = [light.position_m.astype(np.float64) for light in world.lights]
    wanted = [place for place in wanted if np.linalg.norm(place - middle) <= far_m]
    if not wanted:
        return middle[None]
    highest_first = sorted(wanted, key=lambda place: -place[2])
    chosen: list[NDArray[np.float64]] = []
    for light_m in highest_first:
        start = (light_m - [0.0, 0.0, 0.1]).astype(np.float32)[None]
        down = tracer.first_hits(start, np.array([[0, 0, -1]], np.float32), _BEYOND_M)
        drop = float(down.distance[0]) if down.triangle[0] >= 0 else 1.0
        place = light_m - [0.0, 0.0, 0.1 + drop / 2]
        near = [other for other in chosen if np.linalg.norm(other - place) < APART_M]
        offsets = np.array(near, np.float32).reshape(-1, 3) - place.astype(np.float32)
        origins = np.tile(place.astype(np.float32), (len(near), 1))
        if tracer.blocked(origins, offsets).all():
            chosen.append(place)
    return np.array(chosen[:MOST_PROBES])


def look_around(place_m: NDArray[np.float64], lights: Sequence[Light], view: FaceView) -> Probe:
    """Render the six faces of a probe, with the lights painted in, and measure the room."""
    camera = face_camera()
    rays = pixel_rays(camera)
    faces = np.empty((6, FACE_PX, FACE_PX, 3), np.float32)
    reach = np.empty(6)
    middle = slice(FACE_PX // 4, -FACE_PX // 4)
    for face, rotation in enumerate(face_rotations()):
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = rotation, place_m
        faces[face], depth = view(camera, pose)
        reach[face] = min(float(np.median(depth[middle, middle])), _BEYOND_M)
        rays_of_face = rays @ rotation.T
        for light in lights:
            if may_show(rotation, light.position_m - place_m, light):
                paint_light(faces[face], depth, rays_of_face, place_m, light)
    forward, left, back, right, up, down = reach
    return Probe(
        position_m=place_m,
        lower_m=place_m - np.array([back, right, down]),
        upper_m=place_m + np.array([forward, left, up]),
        faces_cd_m2=faces,
    )


def may_show(rotation: NDArray[np.float64], to_light_m: NDArray[np.float64], light: Light) -> bool:
    """True if a face of 90 degrees with (3, 3) axes may show a light: its bounding sphere is in view."""
    x, y, z = to_light_m @ rotation
    reach = light.radius_m if light.normal is None else float(np.linalg.norm(light.half_u_m + light.half_v_m))
    return bool(z > -reach and max(abs(x), abs(y)) - z < math.sqrt(2) * reach)


def paint_light(
    luminance: NDArray[np.float32],
    depth_m: NDArray[np.float32],
    rays: NDArray[np.float64],
    place_m: NDArray[np.float64],
    light: Light,
) -> None:
    """Paint a light's luminance into a face where nothing hides it, keeping the illuminance it gives.

    - `luminance`: (H, W, 3), painted into [cd/m2].
    - `depth_m`: (H, W) [m].
    - `rays`: (H, W, 3) directions of the pixels in the world, of depth 1 [1].
    """
    to_light = light.position_m - place_m
    if light.normal is None:
        area = math.pi * light.radius_m**2
        along = rays @ to_light / np.einsum("...j,...j->...", rays, rays)
        miss = np.linalg.norm(along[..., None] * rays - to_light, axis=-1)
        hit = (along > 0) & (miss <= light.radius_m)
        intensity = light.flux_lm / (4 * np.pi)  # [cd]
    else:
        towards = rays @ light.normal
        along = (to_light @ light.normal) / np.where(np.abs(towards) > 1e-9, towards, 1e-9)
        across = along[..., None] * rays - to_light
        u2, v2 = float(light.half_u_m @ light.half_u_m), float(light.half_v_m @ light.half_v_m)
        inside = (np.abs(across @ light.half_u_m) <= u2) & (np.abs(across @ light.half_v_m) <= v2)
        hit = (along > 0) & (towards < 0) & inside
        cosine = max(float(-to_light @ light.normal) / float(np.linalg.norm(to_light)), 0.0)
        area = 4 * math.sqrt(u2 * v2) * cosine
        intensity = light.flux_lm / np.pi * cosine
    if not hit.any() or area <= 0:
        return
    # Whole pixels never cover exactly the light's solid angle: scale so that its illuminance is kept.
    pixel_sr = (2 / len(luminance)) ** 2 / np.linalg.norm(rays[hit], axis=-1) ** 3
    covered_sr, true_sr = float(pixel_sr.sum()), area / float(to_light @ to_light)
    # A light cut by the face's edge keeps its luminance.
    cut = hit[0].any() or hit[-1].any() or hit[:, 0].any() or hit[:, -1].any()
    factor = 1.0 if cut else true_sr / covered_sr
    luminance[hit & (along < depth_m + _ON_SURFACE_M)] = (intensity / area * factor).astype(np.float32)
