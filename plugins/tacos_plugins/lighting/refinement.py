"""Splitting large triangles, so that light is known inside them and not only at their corners."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tacos_framework import MeshPart, World


def refined(world: World, edge_m: float) -> World:
    """The same surfaces in triangles with no edge longer than `edge_m` [m].

    A part keeps its vertices, in their order; those that are added come after them.
    """
    return replace(world, parts=tuple(_refined(part, edge_m) for part in world.parts), indirect_lux=None)


def _refined(part: MeshPart, edge_m: float) -> MeshPart:
    """Split in four, again and again, whatever triangle has a long edge."""
    attributes = np.hstack([part.vertices_m, part.normals, part.uv_m]).astype(np.float32)
    small: list[NDArray[np.int32]] = []
    triangles = part.triangles
    while (long := _has_long_edge(attributes[triangles, :3], edge_m)).any():
        small.append(triangles[~long])
        a, b, c = triangles[long].T
        first = len(attributes) + 3 * np.arange(len(a), dtype=np.int32)
        ab, bc, ca = first, first + 1, first + 2
        middles = np.stack([attributes[[a, b]], attributes[[b, c]], attributes[[c, a]]]).mean(axis=1)
        attributes = np.concatenate([attributes, middles.transpose(1, 0, 2).reshape(-1, 8)])
        fans = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        triangles = np.concatenate([np.column_stack(fan) for fan in fans]).astype(np.int32)
    if not small:
        return part
    small.append(triangles)
    normals = attributes[:, 3:6]
    normals = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    return replace(
        part,
        vertices_m=attributes[:, :3],
        normals=normals,
        uv_m=attributes[:, 6:],
        triangles=np.concatenate(small),
    )


def _has_long_edge(corners_m: NDArray[np.float32], edge_m: float) -> NDArray[np.bool_]:
    """(T,) whether an edge of (T, 3, 3) triangles is longer than `edge_m` [m]."""
    edges_m = corners_m - corners_m.take([1, 2, 0], axis=1)
    return np.asarray((np.linalg.norm(edges_m, axis=2) > edge_m).any(axis=1))
