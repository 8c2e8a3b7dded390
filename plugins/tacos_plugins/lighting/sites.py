"""Places where light is computed: vertices that look alike to the light share one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_framework import World
from tacos_plugins.lighting.occlusion import Occlusion

_NUDGE_M = 0.04
"""Largest move of a site from its vertex into its triangles [m]."""


@dataclass(frozen=True, eq=False)
class Sites:
    points_m: NDArray[np.float32]
    normals: NDArray[np.float32]
    """(S, 3) float32 [m]."""
    material: NDArray[np.int32]
    """(S,) index into `World.materials`."""
    of_vertex: NDArray[np.int32]
    """(V,) site of each vertex of all parts."""


def merge_vertices(world: World, occlusion: Occlusion, merge_m: float) -> Sites:
    """Merge vertices of one material within a cell of `merge_m` whose normals are similar.

    A site lies a little inside the triangles of its vertex: a vertex itself often sits in a crease or under
    a skirting board, where no light arrives, though the surface beside it is lit.
    """
    if not world.parts:
        empty = np.zeros((0, 3), np.float32)
        return Sites(empty, empty, np.zeros(0, np.int32), np.zeros(0, np.int32))
    normals = np.concatenate([part.normals for part in world.parts])
    material = np.concatenate(
        [np.full(len(part.vertices_m), part.material, np.int32) for part in world.parts]
    )
    cells = np.floor(occlusion.vertices_m / merge_m).astype(np.int64)
    cells -= cells.min(axis=0)
    facing = np.rint(normals * 1.4).astype(np.int64) + 1
    key = material.astype(np.int64)
    for column, size in ((cells, 1 << 15), (facing, 3)):
        for axis in range(3):
            key = key * size + column[:, axis]
    _, chosen, of_vertex = np.unique(key, return_index=True, return_inverse=True)
    inward = _inward(occlusion)
    # On a rounded edge the triangles lie below the tangent plane, and the way to them leads inside the thing.
    below = np.minimum(np.einsum("ij,ij->i", inward, normals), 0)
    points = occlusion.vertices_m + inward - below[:, None] * normals
    return Sites(
        points_m=points[chosen].astype(np.float32),
        normals=normals[chosen],
        material=material[chosen],
        of_vertex=of_vertex.reshape(-1).astype(np.int32),
    )


def _inward(occlusion: Occlusion) -> NDArray[np.float32]:
    """(V, 3) from each vertex towards the mean centre of its triangles, at most `_NUDGE_M` long [m]."""
    vertices, triangles = occlusion.vertices_m, occlusion.triangles
    centres = vertices[triangles].mean(axis=1)
    count = np.maximum(np.bincount(triangles.reshape(-1), minlength=len(vertices)), 1)
    mean_centre = np.stack(
        [
            np.bincount(triangles.reshape(-1), np.repeat(centres[:, axis], 3), minlength=len(vertices))
            / count
            for axis in range(3)
        ],
        axis=1,
    )
    inward = mean_centre - vertices
    length = np.maximum(np.linalg.norm(inward, axis=1, keepdims=True), 1e-9)
    return np.asarray(inward / length * np.minimum(_NUDGE_M, 0.3 * length), dtype=np.float32)
