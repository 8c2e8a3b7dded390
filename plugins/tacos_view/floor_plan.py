"""A world from above, cut open below its ceilings, with the trip through it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Camera, Trajectory, World
from tacos_framework.camera import srgb_from_linear
from tacos_view.pictures import Picture

Triangles = NDArray[np.float64]
"""(T, 3, 3) corners in the world [m]."""

_ABOVE_EYE_M = 0.3
_ROOM_MARGIN_M, _OPEN_MARGIN_M = 8.0, 30.0
_PATH, _CAMERA, _WALL = (213, 94, 0), (0, 114, 178), (45, 48, 54)
_JUMP_STEPS = 8.0
"""Between keys of a trajectory that lie so many usual steps apart the agent has jumped to another walk."""


@dataclass(frozen=True, eq=False)
class _Sheet:
    """A piece of the ground on a picture: world x to the right, y up."""

    lower_m: NDArray[np.float64]
    upper_m: NDArray[np.float64]
    px_per_m: float

    @property
    def shape(self) -> tuple[int, int, int]:
        width, height = (self.upper_m - self.lower_m) * self.px_per_m
        return max(1, math.ceil(height)), max(1, math.ceil(width)), 3

    def pixels(self, points_m: NDArray[np.float64]) -> NDArray[np.int32]:
        """(..., 2) places on the ground as (column, row)."""
        right = (points_m[..., 0] - self.lower_m[0]) * self.px_per_m
        down = (self.upper_m[1] - points_m[..., 1]) * self.px_per_m
        return np.stack([right, down], axis=-1).round().astype(np.int32)


def floor_plan(
    world: World,
    trajectory: Trajectory,
    world_from_camera: NDArray[np.float64],
    camera: Camera,
    *,
    widest_px: int = 900,
) -> Picture:
    """A world from above, the agent's path, and where a camera looked from.

    Where something covers the agent, it is left out: of a building the walls are shown as they are cut a
    little above the eye.

    `world_from_camera`: (N, 4, 4) poses of the frames, which are numbered from 1 [m].
    """
    triangles, colours = _coloured_triangles(world)
    eyes = world_from_camera[:, :3, 3]
    covered = _covered(triangles, eyes)
    cut_m = float(np.median(eyes[:, 2])) + _ABOVE_EYE_M if covered else math.inf
    sheet = _sheet(triangles, trajectory, _ROOM_MARGIN_M if covered else _OPEN_MARGIN_M, widest_px)
    picture = np.full(sheet.shape, 240, np.uint8)
    _paint_surfaces(picture, sheet, triangles, colours, cut_m)
    _paint_section(picture, sheet, triangles, cut_m)
    _paint_trip(picture, sheet, trajectory, world_from_camera, camera)
    return picture


def _coloured_triangles(world: World) -> tuple[Triangles, NDArray[np.uint8]]:
    corners, colours = [], []
    for part in world.parts:
        material = world.materials[part.material]
        tone = np.asarray(material.base_colour, np.float64)
        if material.texture is not None:
            tone = tone * ((material.texture / 255.0) ** 2.2).mean(axis=(0, 1))
        own = part.vertices_m[part.triangles].astype(np.float64)
        normals = np.cross(own[:, 1] - own[:, 0], own[:, 2] - own[:, 0])
        length = np.linalg.norm(normals, axis=-1)
        upright = np.divide(np.abs(normals[:, 2]), length, out=np.zeros(len(own)), where=length > 0)
        corners.append(own)
        shade = 0.35 + 0.65 * upright
        colours.append(np.rint(255 * srgb_from_linear(np.clip(tone * shade[:, None], 0, 1))).astype(np.uint8))
    if not corners:
        return np.zeros((0, 3, 3)), np.zeros((0, 3), np.uint8)
    return np.concatenate(corners), np.concatenate(colours)


def _covered(triangles: Triangles, eyes_m: NDArray[np.float64]) -> bool:
    """True if most places of the camera have something above them."""
    a, b, c = (triangles[:, i, :2] for i in range(3))
    whole = _twice_area(a, b, c)
    top = triangles[..., 2].min(axis=1)
    count = 0
    for eye in eyes_m:
        at = eye[:2]
        parts = np.stack([_twice_area(a, b, at), _twice_area(b, c, at), _twice_area(c, a, at)])
        inside = (parts * np.sign(whole) >= 0).all(axis=0) & (whole != 0)
        count += bool((inside & (top > eye[2])).any())
    return count > len(eyes_m) / 2


def _twice_area(
    a: NDArray[np.float64], b: NDArray[np.float64], c: NDArray[np.float64]
) -> NDArray[np.float64]:
    first, second = b - a, c - a
    area: NDArray[np.float64] = first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0]
    return area


def _sheet(triangles: Triangles, trajectory: Trajectory, margin_m: float, widest_px: int) -> _Sheet:
    path = trajectory.world_from_agent[:, :2, 3]
    ground = triangles.reshape(-1, 3)[:, :2]
    world_lower, world_upper = (ground.min(0), ground.max(0)) if len(ground) else (path.min(0), path.max(0))
    lower = np.maximum(path.min(0) - margin_m, world_lower) - 0.2
    upper = np.minimum(path.max(0) + margin_m, world_upper) + 0.2
    return _Sheet(lower, upper, widest_px / float((upper - lower).max()))


def _paint_surfaces(
    picture: Picture, sheet: _Sheet, triangles: Triangles, colours: NDArray[np.uint8], cut_m: float
) -> None:
    import cv2

    heights = triangles[..., 2]
    kept = np.flatnonzero(heights.max(axis=1) < cut_m)
    kept = kept[np.argsort(heights[kept].mean(axis=1), kind="stable")]
    outlines = sheet.pixels(triangles[kept, :, :2])
    for outline, colour in zip(outlines, colours[kept].tolist(), strict=True):
        cv2.fillConvexPoly(picture, outline, colour)


def _paint_section(picture: Picture, sheet: _Sheet, triangles: Triangles, cut_m: float) -> None:
    import cv2

    height = triangles[..., 2] - cut_m if math.isfinite(cut_m) else np.full(triangles.shape[:2], -1.0)
    for i in np.flatnonzero((height.min(axis=1) < 0) & (height.max(axis=1) >= 0)):
        ends = []
        for j in range(3):
            k = (j + 1) % 3
            if (height[i, j] < 0) != (height[i, k] < 0):
                share = height[i, j] / (height[i, j] - height[i, k])
                ends.append(triangles[i, j, :2] + share * (triangles[i, k, :2] - triangles[i, j, :2]))
        start, end = sheet.pixels(np.array(ends)).tolist()
        cv2.line(picture, start, end, _WALL, 2, cv2.LINE_AA)


def _paint_trip(
    picture: Picture,
    sheet: _Sheet,
    trajectory: Trajectory,
    world_from_camera: NDArray[np.float64],
    camera: Camera,
) -> None:
    import cv2

    places = trajectory.world_from_agent[:, :2, 3]
    path = sheet.pixels(places).tolist()
    steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
    usual = float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0
    for start, end, step in zip(path[:-1], path[1:], steps, strict=True):
        if step <= _JUMP_STEPS * usual:
            cv2.line(picture, start, end, _PATH, 2, cv2.LINE_AA)
    reach_m = 0.09 * max(picture.shape) / sheet.px_per_m
    half = min(math.radians(camera.hfov_deg) / 2, math.pi / 2)
    overlay = picture.copy()
    wedges = []
    for pose in world_from_camera:
        ahead = math.atan2(pose[1, 2], pose[0, 2])
        angles = ahead + np.linspace(half, -half, 13)
        rim = pose[:2, 3] + reach_m * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
        wedges.append(sheet.pixels(np.vstack([pose[:2, 3], rim])))
        cv2.fillPoly(overlay, [wedges[-1]], _CAMERA)
    cv2.addWeighted(overlay, 0.35, picture, 0.65, 0, dst=picture)
    for number, wedge in enumerate(wedges, start=1):
        cv2.polylines(picture, [wedge], True, _CAMERA, 2, cv2.LINE_AA)
        at = (wedge[0] + 0.6 * (wedge[7] - wedge[0])).astype(int).tolist()
        for colour, width in (((255, 255, 255), 4), (_WALL, 1)):
            place = (at[0] - 5, at[1] + 6)
            cv2.putText(
                picture, str(number), place, cv2.FONT_HERSHEY_SIMPLEX, 0.6, colour, width, cv2.LINE_AA
            )
