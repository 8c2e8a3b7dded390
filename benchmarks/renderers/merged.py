"""Parts of a world put together, so that a renderer has few things to draw."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_framework import MeshPart, World


@dataclass(frozen=True, eq=False)
class Merged:
    """Parts that share something, as one mesh.

    Parameters
    ----------
    shared
        The index of the material or the object they share.
    position_m, normal, uv
        (V, 3), (V, 3), (V, 2) float32; texture coordinates in tiles [m, 1, 1].
    object_id
        (V,) int32.
    triangles
        (T, 3) int32.
    """

    shared: int
    position_m: NDArray[np.float32]
    normal: NDArray[np.float32]
    uv: NDArray[np.float32]
    object_id: NDArray[np.int32]
    triangles: NDArray[np.int32]


def by_material(world: World) -> Iterator[Merged]:
    """One mesh per material that has triangles."""
    return _merge(world, lambda part: part.material)


def by_object(world: World) -> Iterator[Merged]:
    """One mesh per object that has triangles."""
    return _merge(world, lambda part: part.object_id)


def _merge(world: World, key: Callable[[MeshPart], int]) -> Iterator[Merged]:
    for shared in sorted({key(part) for part in world.parts if len(part.triangles)}):
        parts = [part for part in world.parts if key(part) == shared]
        counts = [len(part.vertices_m) for part in parts]
        starts = np.cumsum([0, *counts[:-1]])
        yield Merged(
            shared,
            np.concatenate([part.vertices_m for part in parts]),
            np.concatenate([part.normals for part in parts]),
            np.concatenate(
                [part.uv_m / np.float32(world.materials[part.material].texture_size_m) for part in parts]
            ),
            np.repeat([part.object_id for part in parts], counts).astype(np.int32),
            np.concatenate(
                [part.triangles + start for part, start in zip(parts, starts, strict=True)], dtype=np.int32
            ),
        )
