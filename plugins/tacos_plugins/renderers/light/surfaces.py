"""Smooth surfaces made up of triangles, and closed parts."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tacos_plugins.coincident_faces import numbered
from tacos_plugins.renderers.light.flatten import FlatMesh

_SAME_PLACE_M = 1e-4
_SAME_NORMAL = 1 / 16
_LEAST_VOLUME = 1e-9
"""Of the sum over all triangles regardless of sign: less is rounding [1]."""


def smooth_surfaces(mesh: FlatMesh) -> NDArray[np.int32]:
    """(V,) the surface each vertex belongs to, numbered from 1.

    A surface is a run of triangles of one part joined along vertices of the same place and normal: light
    changes steadily on it, and jumps from one surface to the next.
    """
    from scipy.sparse import coo_array  # late: checking a recipe draws nothing
    from scipy.sparse.csgraph import connected_components

    if len(mesh.position_m) == 0:
        return np.zeros(0, np.int32)
    place = np.round(mesh.position_m / _SAME_PLACE_M).astype(np.int64)
    facing = np.round(mesh.normal / _SAME_NORMAL).astype(np.int64)
    part = np.zeros(len(place), np.int64)
    part[mesh.triangles] = mesh.part[:, None]
    merged = numbered(np.column_stack([part, place, facing]))
    a, b, c = merged[mesh.triangles].T
    edges = np.concatenate([a, b]), np.concatenate([b, c])
    size = int(merged.max()) + 1
    joined = coo_array((np.ones(len(edges[0]), np.int8), edges), shape=(size, size))
    _, label = connected_components(joined, directed=False)
    return (label[merged] + 1).astype(np.int32)


def closed_parts(mesh: FlatMesh) -> NDArray[np.bool_]:
    """(parts,) whether each part encloses a volume, so that its back is never seen from outside.

    True where every edge is run along as often in one direction as in the other, and the enclosed volume is
    positive: a room that faces inwards is not closed in this sense. Sheets that enclose nothing but rounding
    are not, either.
    """
    parts = int(mesh.part.max(initial=-1)) + 1
    if parts == 0:
        return np.zeros(0, dtype=bool)
    place = numbered(np.round(mesh.position_m / _SAME_PLACE_M).astype(np.int64))[mesh.triangles]
    size = int(place.max()) + 1
    start, end = place.reshape(-1), np.roll(place, -1, axis=1).reshape(-1)
    part = np.repeat(mesh.part.astype(np.int64), 3)
    there = np.sort((part * size + start) * size + end)
    back = np.sort((part * size + end) * size + start)
    # Sorted per part alike, edges and reversed edges of a closed part are the same list.
    unpaired = there != back
    lonely = np.bincount(there[unpaired] // size // size, minlength=parts) > 0
    lonely |= np.bincount(back[unpaired] // size // size, minlength=parts) > 0
    corners = mesh.corners_m.astype(np.float64)
    corners -= mesh.position_m.mean(axis=0)
    six_volumes = np.einsum("tj,tj->t", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    volume = np.bincount(mesh.part, six_volumes, minlength=parts)
    least = _LEAST_VOLUME * np.bincount(mesh.part, np.abs(six_volumes), minlength=parts)
    return ~lonely & (volume > least)
