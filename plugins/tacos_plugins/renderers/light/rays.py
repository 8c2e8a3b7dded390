"""Shadows: rays against a mesh, traced by Embree on the CPU."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from embreex import rtcore_scene
from embreex.mesh_construction import TriangleMesh
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class RayHits:
    triangle: NDArray[np.int32]
    """(N,) int32; -1 where nothing is met."""
    distance: NDArray[np.float32]
    """(N,) float32 in lengths of the given direction [1]."""
    barycentric: NDArray[np.float32]
    """(N, 2) float32 weights of the triangle's second and third corner [1]."""
    from_behind: NDArray[np.bool_]
    """(N,) bool: the ray met the back of the triangle."""


class RayTracer:
    """A mesh that rays can be traced against.

    - `corners_m`: (T, 3, 3) corners of the triangles [m].
    """

    def __init__(self, corners_m: NDArray[np.float32]):
        self._empty = len(corners_m) == 0
        self._scene = rtcore_scene.EmbreeScene()
        if not self._empty:
            TriangleMesh(self._scene, np.ascontiguousarray(corners_m, dtype=np.float32))

    def blocked(self, origin_m: NDArray[np.float32], to_m: NDArray[np.float32]) -> NDArray[np.bool_]:
        """(N,) whether anything lies between (N, 3) origins and origins + `to_m` [m]."""
        if self._empty or len(origin_m) == 0:
            return np.zeros(len(origin_m), dtype=bool)
        reach = np.ones(len(origin_m), dtype=np.float32)
        hit = self._scene.run(
            np.ascontiguousarray(origin_m), np.ascontiguousarray(to_m), dists=reach, query="OCCLUDED"
        )
        return hit != -1

    def first_hits(
        self, origin_m: NDArray[np.float32], direction: NDArray[np.float32], reach: float
    ) -> RayHits:
        """First hits of (N, 3) rays, no farther than `reach` lengths of their direction."""
        count = len(origin_m)
        if self._empty or count == 0:
            return RayHits(
                triangle=np.full(count, -1, np.int32),
                distance=np.full(count, reach, np.float32),
                barycentric=np.zeros((count, 2), np.float32),
                from_behind=np.zeros(count, dtype=bool),
            )
        found = self._scene.run(
            np.ascontiguousarray(origin_m),
            np.ascontiguousarray(direction),
            dists=np.full(count, reach, np.float32),
            output=1,
        )
        return RayHits(
            triangle=found["primID"],
            distance=found["tfar"],
            barycentric=np.column_stack([found["u"], found["v"]]),
            from_behind=np.einsum("ij,ij->i", found["Ng"], direction) > 0,
        )
