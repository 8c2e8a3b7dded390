"""Normals of surfaces that come without: smooth where a surface bends, sharp at its edges."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tacos_worlds.kit.models.patch import Patch, welded

CREASE_DEG = 35.0
"""Triangles that meet at a larger angle make an edge [deg]."""


def with_normals(patch: Patch) -> Patch:
    """A patch with normals: its own, or else means over the neighbours that hardly turn away.

    Each corner of a triangle gets the mean, weighted by area, of the normals of those triangles at its vertex
    that lean away from its own by less than `CREASE_DEG`. Corners that come out alike share a vertex.
    """
    if patch.normals is not None:
        return patch
    place = welded(patch.vertices_m)[patch.triangles].reshape(-1)
    cross = patch.crosses
    unit = cross / np.maximum(np.linalg.norm(cross, axis=1, keepdims=True), 1e-30)
    order = np.argsort(place, kind="stable")
    starts = np.flatnonzero(np.concatenate([[True], np.diff(place[order]) > 0]))
    counts = np.diff(np.append(starts, len(order)))
    normal = np.zeros((len(place), 3))
    # Corners around each place, compared with the one `shift` further on, all places at once.
    begin, count = np.repeat(starts, counts), np.repeat(counts, counts)
    within = np.arange(len(order)) - begin
    triangle = order // 3
    for shift in range(int(counts.max(initial=0))):
        has = np.flatnonzero(shift < count)
        other = triangle[begin[has] + (within[has] + shift) % count[has]]
        near = np.einsum("ij,ij->i", unit[triangle[has]], unit[other]) > math.cos(math.radians(CREASE_DEG))
        normal[order[has[near]]] += cross[other[near]]
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30)
    return _shared(patch, normal)


def _shared(patch: Patch, normal: NDArray[np.float64]) -> Patch:
    """Vertices of their own for corners of different normals."""
    corner = patch.triangles.reshape(-1)
    key = np.column_stack([corner, np.round(normal * 256).astype(np.int64)])
    _, first, inverse = np.unique(key, axis=0, return_index=True, return_inverse=True)
    vertex = corner[first]
    return replace(
        patch,
        vertices_m=patch.vertices_m[vertex],
        triangles=inverse.reshape(-1, 3).astype(np.int64),
        normals=normal[first],
        uv=None if patch.uv is None else patch.uv[vertex],
        colours=None if patch.colours is None else patch.colours[vertex],
    )
