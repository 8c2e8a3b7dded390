"""Levels of detail: surfaces far from where the agent walks are drawn with fewer triangles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from tacos_worlds.kit.models.patch import Patch

_RINGS_M = (4.0, 12.0, 40.0)
"""Distances to the way at which detail falls: a surface three times as far may err three times as much
[m]."""
_FEWEST = 64
"""Patches of so few triangles are left as they are."""


def simplified(patches: Sequence[Patch], eyes_m: NDArray[np.float64], most: int) -> list[Patch]:
    """Patches with no more than about `most` triangles in all, the share of each by its distance to the eye.

    Patches are cut into rings around the walkable floor. Where all is too much, each ring may keep triangles
    in proportion to what it has and to one over its distance, as errors look smaller from afar. Quadric
    errors choose what goes (Garland and Heckbert, 1997, Surface simplification using quadric error metrics).
    """
    if sum(len(patch.triangles) for patch in patches) <= most:
        return list(patches)
    rings = [piece for patch in patches for piece in _by_distance(patch, eyes_m)]
    counts = np.array([len(piece.triangles) for piece, _ in rings], np.float64)
    closeness = np.array([1 / max(distance, _RINGS_M[0]) for _, distance in rings])
    keep = _shares(counts, closeness, most)
    return [
        _fewer(piece, int(count)) if count < len(piece.triangles) else piece
        for (piece, _), count in zip(rings, np.maximum(keep, _FEWEST), strict=True)
    ]


def _shares(counts: NDArray[np.float64], closeness: NDArray[np.float64], most: int) -> NDArray[np.float64]:
    """Triangles that each piece keeps: a common factor of count times closeness, no more than it has."""
    low, high = 0.0, float(1 / closeness.min())
    for _ in range(60):
        factor = (low + high) / 2
        kept = np.minimum(counts, factor * counts * closeness)
        low, high = (factor, high) if kept.sum() < most else (low, factor)
    return np.asarray(np.minimum(counts, low * counts * closeness))


def _by_distance(patch: Patch, eyes_m: NDArray[np.float64]) -> list[tuple[Patch, float]]:
    """A patch in rings around the eyes, each with its distance [m]."""
    centres = patch.vertices_m[patch.triangles].mean(axis=1)
    distance = np.asarray(cKDTree(eyes_m).query(centres)[0], np.float64)
    ring = np.searchsorted(_RINGS_M, distance)
    return [
        (patch.with_triangles(patch.triangles[ring == each]), float(distance[ring == each].mean()))
        for each in np.unique(ring)
    ]


def _fewer(patch: Patch, count: int) -> Patch:
    """The same surface in about `count` triangles; what belonged to vertices is taken from those merged."""
    import fast_simplification

    points, faces, collapses = fast_simplification.simplify(
        patch.vertices_m.astype(np.float32),
        patch.triangles.astype(np.int32),
        target_count=max(count, 4),
        return_collapses=True,
    )
    points, faces, merged_into = fast_simplification.replay_simplification(
        patch.vertices_m.astype(np.float32), patch.triangles.astype(np.int32), collapses
    )
    if not len(faces):
        return patch
    source = _nearest_merged(patch.vertices_m, np.asarray(points, np.float64), np.asarray(merged_into))
    return replace(
        patch,
        vertices_m=np.asarray(points, np.float64),
        triangles=np.asarray(faces, np.int64),
        normals=None,
        uv=None if patch.uv is None else patch.uv[source],
        colours=None if patch.colours is None else patch.colours[source],
    )


def _nearest_merged(
    vertices_m: NDArray[np.float64], points_m: NDArray[np.float64], merged_into: NDArray[np.integer]
) -> NDArray[np.intp]:
    """(P,) for each new vertex the nearest of the old ones that were merged into it.

    Nearest of all vertices would be wrong: beside a seam of the texture lie those of its other side.
    """
    known = np.flatnonzero((merged_into >= 0) & (merged_into < len(points_m)))
    into = merged_into[known]
    distance = np.linalg.norm(vertices_m[known] - points_m[into], axis=1)
    order = np.lexsort((distance, into))
    place, first = np.unique(into[order], return_index=True)
    source = np.zeros(len(points_m), np.intp)
    source[place] = known[order][first]
    return source
