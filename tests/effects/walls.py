"""Walls across the way with waves of light on them, cast ray by ray in closed form: a reference renderer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_framework.camera import pixel_rays, world_from_camera
from tacos_framework.values import Camera, Episode, Trajectory, View

WAVES = 12


@dataclass(frozen=True)
class Wall:
    """A wall in the plane x = `distance_m`, from side to side by `half_m` about y = 0 and z = 1.5 m."""

    distance_m: float
    half_m: float
    object_id: int = 0
    finest: float = 3.0
    """Most waves of its light over a metre [1/m]."""
    way: Trajectory | None = None
    """How it moves by itself, from where it stands."""

    def light(self, y: NDArray[np.float64], z: NDArray[np.float64]) -> NDArray[np.float64]:
        """Luminance at places of it, around 1 [cd/m2]."""
        rng = np.random.default_rng(self.object_id)
        waves = rng.uniform(-self.finest, self.finest, (WAVES, 2))
        phases = rng.uniform(0, 6, WAVES)
        total = sum(np.cos(2 * np.pi * (a * y + b * z) + p) for (a, b), p in zip(waves, phases, strict=True))
        return np.asarray(1 + total / WAVES)


def cast(episode: Episode, camera: Camera, walls: Sequence[Wall]) -> View:
    """What a camera sees of walls at the one moment of an episode."""
    time_s = episode.time_s[:1]
    pose = world_from_camera(episode.trajectory.at(time_s), camera.agent_from_camera)
    rays = pixel_rays(camera) @ pose[0, :3, :3].T
    depth = np.full(rays.shape[:2], np.inf)
    light, ids = np.zeros(rays.shape[:2]), np.zeros(rays.shape[:2], int)
    for wall in walls:
        moved = np.eye(4) if wall.way is None else wall.way.at(time_s)[0]
        back = np.linalg.inv(moved)
        origin, directions = back[:3, :3] @ pose[0, :3, 3] + back[:3, 3], rays @ back[:3, :3].T
        with np.errstate(divide="ignore", invalid="ignore"):
            along = (wall.distance_m - origin[0]) / directions[..., 0]
            y, z = (origin[axis] + along * directions[..., axis] for axis in (1, 2))
        seen = (along > 0) & (along < depth) & (np.abs(y) < wall.half_m) & (np.abs(z - 1.5) < wall.half_m)
        depth[seen], ids[seen] = along[seen], wall.object_id
        light[seen] = wall.light(y[seen], z[seen])
    return View(camera, pose, np.repeat(light[None, ..., None], 3, axis=-1), depth[None], ids[None])
