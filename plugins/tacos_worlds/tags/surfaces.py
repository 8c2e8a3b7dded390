"""Places for a flat sheet in a world: upright, even and seen from the agent's way."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Episode, World

Floats = NDArray[np.float64]

UPRIGHT = 0.1
"""Walls lean by no more than this [sine of the lean]."""
NEAREST_M = 0.8
EVEN_M = 0.004
"""A wall is as even as this over the sheet [m]."""
TRIES = 400


@dataclass(frozen=True, eq=False)
class Surface:
    """A triangle soup: (T, 3, 3) corners [m], (T, 3) normals, and of which part each triangle is."""

    corners_m: Floats
    normals: Floats
    part: NDArray[np.int64]

    @classmethod
    def of(cls, world: World) -> Surface:
        still = [
            (number, part)
            for number, part in enumerate(world.parts)
            if not world.objects[part.object_id].moves
        ]
        corners = np.concatenate([part.vertices_m[part.triangles] for _, part in still]).astype(np.float64)
        across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        length = np.linalg.norm(across, axis=1, keepdims=True)
        numbers = np.concatenate([np.full(len(part.triangles), number) for number, part in still])
        kept = length[:, 0] > 1e-12
        return cls(corners[kept], across[kept] / length[kept], numbers[kept])

    def hit(self, eye_m: Floats, direction: Floats) -> tuple[float, int]:
        """Distance to the first triangle along a unit vector [m] and its index; infinite where none is.

        Source: Moeller and Trumbore 1997, "Fast, minimum storage ray/triangle intersection".
        """
        origin = self.corners_m[:, 0]
        one, two = self.corners_m[:, 1] - origin, self.corners_m[:, 2] - origin
        p = np.cross(direction, two)
        with np.errstate(divide="ignore", invalid="ignore"):
            inverse = 1 / np.sum(one * p, axis=1)
            s = eye_m - origin
            u = np.sum(s * p, axis=1) * inverse
            q = np.cross(s, one)
            v = (q @ direction) * inverse
            t = np.sum(two * q, axis=1) * inverse
        inside = (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 1e-6)
        distance = np.where(inside, t, np.inf)
        first = int(distance.argmin())
        return float(distance[first]), first


@dataclass(frozen=True, eq=False)
class Place:
    """Place of a sheet: its middle [m], unit vectors to its right and up as it is seen, and the part."""

    middle_m: Floats
    right: Floats
    up: Floats
    part: int

    @property
    def normal(self) -> Floats:
        """Unit vector towards who reads it."""
        return np.asarray(np.cross(self.right, self.up))

    def corners_m(self, edge_m: float) -> Floats:
        """(4, 3) corners of a square, from its lower left counter-clockwise as it is seen [m]."""
        half = edge_m / 2
        steps = [(-half, -half), (half, -half), (half, half), (-half, half)]
        return np.array([self.middle_m + a * self.right + b * self.up for a, b in steps])


def draw_places(rng: np.random.Generator, episode: Episode, edge_m: float) -> Iterator[Place]:
    """Places for square sheets of an edge [m], without overlap, each seen from somewhere on the way."""
    surface = Surface.of(episode.world)
    taken: list[Place] = []
    times_s = rng.uniform(episode.trajectory.time_s[0], episode.trajectory.time_s[-1], TRIES)
    for pose in episode.trajectory.at(times_s):
        turn, lift = rng.uniform(-np.pi, np.pi), rng.uniform(-0.25, 0.15)
        direction = np.array([np.cos(turn) * np.cos(lift), np.sin(turn) * np.cos(lift), np.sin(lift)])
        place = _place(surface, pose[:3, 3], direction, edge_m)
        if place is not None and all(
            np.linalg.norm(place.middle_m - other.middle_m) > 2 * edge_m for other in taken
        ):
            taken.append(place)
            yield place


def _place(surface: Surface, eye_m: Floats, direction: Floats, edge_m: float) -> Place | None:
    """The place that is looked at; None where it is no wall, or not all of the sheet would be on it."""
    distance_m, triangle = surface.hit(eye_m, direction)
    if not NEAREST_M < distance_m < np.inf:
        return None
    normal = surface.normals[triangle]
    normal = -normal if normal @ direction > 0 else normal
    if abs(normal[2]) > UPRIGHT or normal @ direction > -0.3:
        return None
    up = np.array([0.0, 0.0, 1.0]) - normal[2] * normal
    up /= np.linalg.norm(up)
    middle = eye_m + distance_m * direction
    place = Place(middle + EVEN_M / 2 * normal, np.cross(up, normal), up, int(surface.part[triangle]))
    for corner in place.corners_m(edge_m):
        ray = corner - eye_m
        reach_m = float(np.linalg.norm(ray))
        behind_m, _ = surface.hit(eye_m, ray / reach_m)
        off_m = (behind_m - reach_m) * abs(float(normal @ ray)) / reach_m
        if not 0 < off_m < EVEN_M:
            return None
    return place
