"""Parts of a world that a camera may see: chunks inside its frustum, as draw commands."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_plugins.renderers.light.flatten import Chunks, SurfaceKind

_KINDS = 2 * int(max(SurfaceKind))
"""More than any combination of the bits of `SurfaceKind`."""


@dataclass(frozen=True, eq=False)
class DrawList:
    """Indirect draw commands, group after group."""

    commands: NDArray[np.uint32]
    """(N, 5) uint32: index count, instances, first index, base vertex, base instance."""
    groups: tuple[tuple[int, int, int, int], ...]
    """The moving object (0 for what stands still) and the bits of `SurfaceKind` of each group, its first
    command and its number of commands.
    """

    def runs(self, first: int, count: int) -> NDArray[np.int64]:
        """(count, 2) first triangle and number of triangles of some commands."""
        return self.commands[first : first + count, [2, 0]].astype(np.int64) // 3


class Culling:
    """The chunks of a world and the surfaces in them.

    - `triangles`: (T, 3) int32 vertices of the triangles in the order of the chunks.
    - `surface`: (V,) int32 smooth surface of each vertex, from 1.
    """

    def __init__(self, chunks: Chunks, triangles: NDArray[np.int32], surface: NDArray[np.int32]):
        self._chunks = chunks
        chunk = np.repeat(np.arange(len(chunks.first)), chunks.count)
        surfaces = int(surface.max(initial=0)) + 1
        pairs = np.unique(chunk * surfaces + surface[triangles[:, 0]])
        in_chunk, self._surface_in_chunk = np.divmod(pairs, surfaces)
        self._first_pair = np.searchsorted(in_chunk, np.arange(len(chunks.first)))
        self._surfaces = surfaces

    def in_frustum(self, clip_from_world: NDArray[np.float64]) -> NDArray[np.intp]:
        """The chunks whose bounding boxes reach into what a projection keeps, and all that move."""
        chunks, planes = self._chunks, frustum_planes(clip_from_world)
        # The corner of each box that lies farthest along each plane's normal decides.
        farthest = np.where(planes[:, None, :3] > 0, chunks.upper_m, chunks.lower_m)
        inside = np.einsum("pj,pcj->pc", planes[:, :3], farthest) + planes[:, 3:] >= 0
        return np.flatnonzero(inside.all(axis=0) | (chunks.mover > 0))

    def with_surfaces(self, chunk: NDArray[np.intp], surface_seen: NDArray[np.float32]) -> NDArray[np.intp]:
        """Those chunks that hold any of the surfaces in an image of surface numbers."""
        if len(chunk) == 0:
            return chunk
        flat = surface_seen.reshape(-1)
        starts = np.flatnonzero(flat[1:] != flat[:-1]) + 1  # of runs, which are few
        is_seen = np.zeros(self._surfaces, dtype=bool)
        is_seen[flat[:1].astype(np.intp)] = True
        is_seen[flat[starts].astype(np.intp)] = True
        seen = np.logical_or.reduceat(is_seen[self._surface_in_chunk], self._first_pair)
        return chunk[seen[chunk]]

    def draw_list(
        self, chunk: NDArray[np.intp], eye_m: NDArray[np.float64], group_bits: SurfaceKind
    ) -> DrawList:
        """Commands for chunks, grouped by what moves and by the given bits of their kind, nearest first."""
        chunks = self._chunks
        nearest = np.clip(eye_m, chunks.lower_m[chunk], chunks.upper_m[chunk])
        group = chunks.mover[chunk] * _KINDS + (chunks.kind[chunk] & int(group_bits))
        ordered = np.lexsort((np.linalg.norm(nearest - eye_m, axis=1), group))
        chunk, group = chunk[ordered], group[ordered]
        commands = np.zeros((len(chunk), 5), np.uint32)
        commands[:, 0] = 3 * chunks.count[chunk]
        commands[:, 1] = 1
        commands[:, 2] = 3 * chunks.first[chunk]
        numbers, first, count = np.unique(group, return_index=True, return_counts=True)
        mover, bits = np.divmod(numbers, _KINDS)
        groups = zip(mover.tolist(), bits.tolist(), first.tolist(), count.tolist(), strict=True)
        return DrawList(commands, tuple(groups))


def frustum_planes(clip_from_world: NDArray[np.float64]) -> NDArray[np.float64]:
    """The six planes that bound what a projection keeps.

    A point p is inside where ``planes[:, :3] @ p + planes[:, 3] >= 0`` for all of them.

    `clip_from_world`: (4, 4) projection times view [1].

    Returns: (6, 4) float64 with normals of unit length: left, right, first row, last row, near, far [1, m].

    Source: Gribb and Hartmann 2001, "Fast extraction of viewing frustum planes from the world-view-projection
    matrix".
    """
    x, y, z, w = clip_from_world
    planes = np.stack([w + x, w - x, w + y, w - y, w + z, w - z])
    return planes / np.linalg.norm(planes[:, :3], axis=1, keepdims=True)


def looked_up(of_surface: NDArray[np.int32], surface: NDArray[np.float32]) -> NDArray[np.int32]:
    """Entries of a table at each pixel of an image of surface numbers, of which few pixels differ."""
    flat = surface.reshape(-1)
    start = np.concatenate([[0], np.flatnonzero(flat[1:] != flat[:-1]) + 1])
    length = np.diff(start, append=len(flat))
    return np.repeat(of_surface[flat[start].astype(np.intp)], length).reshape(surface.shape)
