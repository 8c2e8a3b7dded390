"""Ray queries against all triangles of a world."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_framework import World

Vectors = NDArray[np.float32]

_RAYS_PER_CALL = 1 << 20
"""Rays handed to Embree at once; bounds the memory of a query."""


@dataclass(frozen=True, eq=False)
class WorldHits:
    triangle: NDArray[np.int32]
    """(N,) int32 index into the triangles of all parts in order; -1 where the ray left the world."""
    barycentric: Vectors
    """(N, 3) float32 weights of the triangle's three vertices [1]."""
    distance_m: NDArray[np.float32]
    """(N,) float32, in lengths of the direction vectors [m]."""


class Occlusion:
    """The triangles of a world, ready for ray queries.

    `vertices_m`: (V, 3) vertices of all parts, one after another [m]. `triangles`: (T, 3) indices into
    `vertices_m`.
    """

    def __init__(self, world: World) -> None:
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene

        counts = [len(part.vertices_m) for part in world.parts]
        first = np.cumsum([0, *counts[:-1]]).astype(np.int32)[: len(counts)]
        self.vertices_m: Vectors = np.concatenate(
            [part.vertices_m for part in world.parts] or [np.zeros((0, 3), np.float32)]
        )
        self.triangles: NDArray[np.int32] = np.concatenate(
            [part.triangles + start for part, start in zip(world.parts, first, strict=True)]
            or [np.zeros((0, 3), np.int32)]
        )
        self._scene = EmbreeScene(robust=True)
        if len(self.triangles):
            TriangleMesh(self._scene, self.vertices_m, self.triangles)

    def visible(self, from_m: Vectors, to_m: Vectors) -> NDArray[np.bool_]:
        """(N,) whether nothing lies between each pair of (N, 3) points [m]."""
        free = np.ones(len(from_m), dtype=bool)
        if not len(self.triangles):
            return free
        for start in range(0, len(from_m), _RAYS_PER_CALL):
            batch = slice(start, start + _RAYS_PER_CALL)
            origins = np.ascontiguousarray(from_m[batch], dtype=np.float32)
            rays = np.ascontiguousarray(to_m[batch] - origins, dtype=np.float32)
            free[batch] = (
                self._scene.run(origins, rays, np.full(len(rays), 1.0, np.float32), query="OCCLUDED") != 0
            )
        return free

    def first_hits(self, origins_m: Vectors, directions: Vectors) -> WorldHits:
        """The first triangle each ray meets, from either side."""
        triangle = np.full(len(origins_m), -1, dtype=np.int32)
        barycentric = np.empty((len(origins_m), 3), dtype=np.float32)
        distance = np.empty(len(origins_m), dtype=np.float32)
        if len(self.triangles):
            for start in range(0, len(origins_m), _RAYS_PER_CALL):
                batch = slice(start, start + _RAYS_PER_CALL)
                found = self._scene.run(
                    np.ascontiguousarray(origins_m[batch], dtype=np.float32),
                    np.ascontiguousarray(directions[batch], dtype=np.float32),
                    output=True,
                )
                triangle[batch], distance[batch] = found["primID"], found["tfar"]
                u, v = found["u"], found["v"]
                for corner, weight in enumerate((1 - u - v, u, v)):
                    barycentric[batch, corner] = weight
        missed = triangle < 0
        barycentric[missed], distance[missed] = 0, np.inf
        return WorldHits(triangle, barycentric, distance)
