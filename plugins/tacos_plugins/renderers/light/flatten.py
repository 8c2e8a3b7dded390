"""A world as one mesh: every part in one set of arrays, cut into chunks that can be culled."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntFlag

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Material, World

CHUNK_TRIANGLES = 128
"""Most triangles in a chunk: fewer cull better, more cost fewer draw commands (measured on llvmpipe)."""

LARGE_TRIANGLE_M = 1.5
"""Triangles longer than this get chunks of their own, so that walls do not widen the bounds of chairs [m]."""

MATTE_ROUGHNESS = 0.8
"""Dielectrics at least this rough are purely Lambertian: no highlight, no reflection [1]."""


@dataclass(frozen=True, eq=False)
class FlatMesh:
    """All parts of a world in one indexed mesh."""

    position_m: NDArray[np.float32]
    normal: NDArray[np.float32]
    """(V, 3) float32 [m, 1]."""
    uv: NDArray[np.float32]
    """(V, 2) float32 texture coordinates in tiles [1]."""
    material: NDArray[np.int32]
    object_id: NDArray[np.int32]
    """(V,) int32."""
    indirect_lux: NDArray[np.float32]
    """(V, 3) float32 indirect irradiance [lux]."""
    triangles: NDArray[np.int32]
    """(T, 3) int32."""
    part: NDArray[np.int32]
    """(T,) int32 index of the part each triangle comes from."""
    light_detail: NDArray[np.float64]
    """(parts,) float64 `Part.light_detail` [1]."""

    @property
    def corners_m(self) -> NDArray[np.float32]:
        """(T, 3, 3) corner positions of each triangle [m]."""
        return self.position_m[self.triangles]

    def summed_at_vertices(self, per_triangle: NDArray[np.floating]) -> NDArray[np.float64]:
        """(V, 3) sums of (T, 3) values over the triangles around each vertex."""
        vertex, count = self.triangles.T.reshape(-1), len(self.position_m)
        sums = [np.bincount(vertex, np.tile(values, 3), minlength=count) for values in per_triangle.T]
        return np.stack(sums, axis=1)


@dataclass(frozen=True, eq=False)
class Chunks:
    """Runs of neighbouring triangles with their bounding boxes."""

    first: NDArray[np.int32]
    count: NDArray[np.int32]
    """(C,) int32 first triangle and number of triangles of each chunk."""
    lower_m: NDArray[np.float64]
    upper_m: NDArray[np.float64]
    """(C, 3) float64 corners of the bounding boxes [m]."""
    kind: NDArray[np.int32]
    """(C,) int32 `SurfaceKind` of its materials; a chunk never mixes kinds."""
    mover: NDArray[np.int32]
    """(C,) int32 the moving object they belong to, 0 for all that stands still; a chunk never mixes them."""


class SurfaceKind(IntFlag):
    """Work of the shader of a surface: the less, the faster it is drawn."""

    MAPPED = 1  # lit by the light map, not per vertex
    TEXTURED = 2
    BUMPY = 4  # with a normal map
    GLOSSY = 8  # reflects specularly, or emits
    CLOSED = 16  # its back is never seen: it encloses a volume, or is one side of a sheet


def kind_of(material: Material) -> SurfaceKind:
    """The kind of surface a material makes, before it is known where its light is kept."""
    kind = SurfaceKind(0)
    if material.texture is not None:
        kind |= SurfaceKind.TEXTURED
    if material.normal_map is not None:
        kind |= SurfaceKind.BUMPY
    if material.metallic > 0 or material.roughness < MATTE_ROUGHNESS or material.emission_cd_m2.any():
        kind |= SurfaceKind.GLOSSY
    return kind


def flatten(world: World, indirect_lux: tuple[NDArray[np.float32], ...]) -> FlatMesh:
    """All parts of `world` in one mesh, with their indirect light.

    `indirect_lux`: one (V, 3) array per part, as `World.indirect_lux` [lux].
    """
    parts = world.parts
    vertex_counts = [len(part.vertices_m) for part in parts]
    first_vertex = np.concatenate([[0], np.cumsum(vertex_counts)]).astype(np.int32)
    tile_m = np.array([material.texture_size_m for material in world.materials], dtype=np.float32)

    def stack(arrays: list[NDArray[np.float32]], width: int) -> NDArray[np.float32]:
        return np.concatenate([np.zeros((0, width), np.float32), *arrays])

    material = np.repeat(np.array([part.material for part in parts], np.int32), vertex_counts)
    return FlatMesh(
        position_m=stack([part.vertices_m for part in parts], 3),
        normal=stack([part.normals for part in parts], 3),
        uv=stack([part.uv_m for part in parts], 2) / tile_m[material][:, None],
        material=material,
        object_id=np.repeat(np.array([part.object_id for part in parts], np.int32), vertex_counts),
        indirect_lux=stack(list(indirect_lux), 3),
        triangles=np.concatenate(
            [np.zeros((0, 3), np.int32)]
            + [part.triangles + first for part, first in zip(parts, first_vertex, strict=False)]
        ).astype(np.int32),
        part=np.repeat(np.arange(len(parts), dtype=np.int32), [len(part.triangles) for part in parts]),
        light_detail=np.array([part.light_detail for part in parts], np.float64),
    )


def movers(world: World, mesh: FlatMesh) -> NDArray[np.int32]:
    """(T,) the moving object that each triangle belongs to, 0 for all that stands still."""
    moves = np.array([thing.moves for thing in world.objects], dtype=bool)
    owner = mesh.object_id[mesh.triangles[:, 0]]
    return np.where(moves[owner], owner, 0).astype(np.int32)


def cut_into_chunks(
    mesh: FlatMesh, kind: NDArray[np.int32], mover: NDArray[np.int32]
) -> tuple[NDArray[np.intp], Chunks]:
    """Sort the triangles of a mesh spatially and cut them into chunks.

    `kind`: (T,) int32 `SurfaceKind` of each triangle. `mover`: (T,) int32 as `movers` gives it.

    Returns:

    - `order`: (T,) the triangles in their new order.
    - `chunks`: runs of that order.
    """
    corners = mesh.corners_m.astype(np.float64)
    lower, upper = corners.min(axis=1), corners.max(axis=1)
    large = (upper - lower).max(axis=1) > LARGE_TRIANGLE_M
    runs: list[NDArray[np.intp]] = []
    group = mover.astype(np.int64) * (int(kind.max(initial=0)) + 1) + kind
    for each in np.unique(group):
        for big in (False, True):
            members = np.flatnonzero((group == each) & (large == big))
            runs += _halve(members, (lower + upper) / 2)
    counts = np.array([len(run) for run in runs], dtype=np.int32)
    order = np.concatenate([np.zeros(0, np.intp), *runs])
    starts = (np.cumsum(counts) - counts).astype(np.int32)
    boxes = np.array([[lower[run].min(axis=0), upper[run].max(axis=0)] for run in runs]).reshape(-1, 2, 3)
    return order, Chunks(
        first=starts,
        count=counts,
        lower_m=boxes[:, 0],
        upper_m=boxes[:, 1],
        kind=kind[order[starts]].astype(np.int32),
        mover=mover[order[starts]].astype(np.int32),
    )


def _halve(members: NDArray[np.intp], centre_m: NDArray[np.float64]) -> list[NDArray[np.intp]]:
    """Split at the median of the longest axis until every run is small enough."""
    if len(members) == 0:
        return []
    if len(members) <= CHUNK_TRIANGLES:
        return [members]
    centres = centre_m[members]
    axis = int(np.argmax(np.ptp(centres, axis=0)))
    ordered = members[np.argsort(centres[:, axis], kind="stable")]
    half = len(ordered) // 2
    return _halve(ordered[:half], centre_m) + _halve(ordered[half:], centre_m)
