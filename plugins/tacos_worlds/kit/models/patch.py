"""A piece of surface on its way into a world: metres, z up, of one skin and one object."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_worlds.kit.models.model import Surface

_LEAST_AREA_M2 = 1e-12


@dataclass(frozen=True, eq=False)
class Patch:
    """Triangles of one skin and one object."""

    vertices_m: NDArray[np.float64]  # (V, 3) float64 [m]
    triangles: NDArray[np.int64]  # (T, 3) int64
    skin: int  # index into the model's skins
    object_id: int  # object of the world
    normals: NDArray[np.float64] | None = None  # (V, 3) or None where they have yet to be worked out
    uv: NDArray[np.float64] | None = None  # (V, 2) in tiles, or None
    colours: NDArray[np.float64] | None = None  # (V, 3) linear reflectance, or None

    def with_triangles(self, triangles: NDArray[np.int64]) -> Patch:
        """The same with other triangles, and only the vertices these use."""
        used, inverse = np.unique(triangles, return_inverse=True)
        return Patch(
            self.vertices_m[used],
            inverse.reshape(-1, 3).astype(np.int64),
            self.skin,
            self.object_id,
            None if self.normals is None else self.normals[used],
            None if self.uv is None else self.uv[used],
            None if self.colours is None else self.colours[used],
        )

    @property
    def crosses(self) -> NDArray[np.float64]:
        """(T, 3) cross products of two edges: normals as long as twice the areas [m2]."""
        a, b, c = (self.vertices_m[self.triangles[:, corner]] for corner in range(3))
        return np.cross(b - a, c - a)

    @property
    def areas_m2(self) -> NDArray[np.float64]:
        """(T,) [m2]."""
        return np.linalg.norm(self.crosses, axis=1) / 2


def sound(surface: Surface, turn: NDArray[np.float64], object_id: int) -> Patch:
    """A surface in metres with z up, without triangles that are nothing or stand there twice.

    `turn`: (3, 3) from the file's axes and unit to metres with z up.
    """
    rotation = turn / np.cbrt(np.linalg.det(turn))
    patch = Patch(
        surface.vertices @ turn.T,
        surface.triangles,
        surface.skin,
        object_id,
        None if surface.normals is None else _repaired(surface.normals @ rotation.T),
        surface.uv,
        None if surface.colours is None else np.clip(surface.colours, 0, 1),
    )
    return patch.with_triangles(patch.triangles[_worth_keeping(patch)])


def _worth_keeping(patch: Patch) -> NDArray[np.bool_]:
    """(T,) whether a triangle has an extent, and is the first in its place that faces its way."""
    keep = patch.areas_m2 > _LEAST_AREA_M2
    rolled = _rolled(welded(patch.vertices_m)[patch.triangles])
    _, first = np.unique(rolled, axis=0, return_index=True)
    unique = np.zeros(len(rolled), bool)
    unique[first] = True
    return keep & unique


def _rolled(triangles: NDArray[np.int64]) -> NDArray[np.int64]:
    """Triangles begun at their lowest vertex, so that equal ones read alike and opposite ones do not."""
    start = np.argmin(triangles, axis=1)
    return np.take_along_axis(triangles, (start[:, None] + np.arange(3)) % 3, axis=1)


def welded(vertices_m: NDArray[np.float64], grid_m: float = 1e-5) -> NDArray[np.int64]:
    """(V,) a number for each vertex, equal for those in one place."""
    if not len(vertices_m):
        return np.zeros(0, np.int64)
    _, number = np.unique(np.round(vertices_m / grid_m).astype(np.int64), axis=0, return_inverse=True)
    return number.reshape(-1)


def _repaired(normals: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Unit normals; None where any is missing, so that all are worked out anew."""
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    if not np.isfinite(length).all() or (length < 0.1).any():
        return None
    return np.asarray(normals / length)
