"""Boxes with bevels, and soft boxes."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from tacos_worlds.kit.mesh import Floats, Indices, Mesh, box_uv, shaded

Size = tuple[float, float, float]

_ROUND_DEG = 80.0
"""Faces that differ by less shade into each other: bevels with their faces, but not face with face [deg]."""
_THIN_BEVEL_M = 0.02
"""Bevels below this are too thin for a seam of the texture to be seen in them [m]."""


def box(size_m: Size, at_m: Size = (0.0, 0.0, 0.0), *, bevel_m: float = 0.006) -> Mesh:
    """A box with bevelled edges (44 triangles), standing on the point `at_m` below its middle [m]."""
    signs, triangles = _bevelled_box()
    half = np.array(size_m) / 2
    inset = min(bevel_m, 0.45 * float(half.min()))
    # Each corner has three vertices; the one of axis k lies on the face across k.
    corner = signs[:, None, :] * (half - inset)
    on_face = np.eye(3)[None] * signs[:, None, :] * inset
    points = (corner + on_face).reshape(-1, 3) + _centre(size_m, at_m)
    return shaded(points, triangles, crease_deg=_ROUND_DEG, whole_bevels=inset < _THIN_BEVEL_M)


def slab(size_m: Size, at_m: Size = (0.0, 0.0, 0.0)) -> Mesh:
    """A plain box with sharp edges (12 triangles), for small and thin things [m]."""
    cube, axis = _cube()
    points = cube.vertices_m * (np.array(size_m) / 2) + _centre(size_m, at_m)
    return Mesh(points, cube.normals, box_uv(points, axis, points), cube.triangles)


def cushion(
    size_m: Size, at_m: Size = (0.0, 0.0, 0.0), *, round_m: float = 0.06, puff_m: float = 0.0, steps: int = 1
) -> Mesh:
    """A soft box: edges rounded by `round_m`, top and bottom bulging by `puff_m` [m]."""
    grid, triangles = _cube_grid(steps, puff_m != 0.0)
    half = np.array(size_m) / 2
    radius = min(round_m, 0.98 * float(half.min()))
    flat = half - radius
    # Grid coordinates beyond 1 lie in the rounded rim, of `steps` rings.
    inner = np.clip(grid, -1, 1) * flat
    rim = np.sign(grid) * np.clip(np.abs(grid) - 1, 0, None)
    length = np.linalg.norm(rim, axis=1, keepdims=True)
    points = inner + rim / np.maximum(length, 1e-9) * radius
    across = (1 - (points[:, 0] / half[0]) ** 2) * (1 - (points[:, 1] / half[1]) ** 2)
    points[:, 2] += puff_m * np.sign(grid[:, 2]) * np.clip(across, 0, None) * (np.abs(grid[:, 2]) > 1)
    return shaded(points + _centre(size_m, at_m), triangles, crease_deg=_ROUND_DEG)


def _centre(size_m: Size, at_m: Size) -> Floats:
    return np.array([at_m[0], at_m[1], at_m[2] + size_m[2] / 2])


@lru_cache(maxsize=1)
def _bevelled_box() -> tuple[Floats, Indices]:
    """(8, 3) corner signs, and triangles over 24 vertices (corner * 3 + axis)."""
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=np.float64)

    def corner(values: tuple[int, int, int]) -> int:
        x, y, z = values
        return (x > 0) * 4 + (y > 0) * 2 + (z > 0)

    quads: list[list[int]] = []
    corners: list[list[int]] = []
    for axis in range(3):
        other, third = (k for k in range(3) if k != axis)
        for sign in (-1, 1):
            ring = []
            for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
                at = [0, 0, 0]
                at[axis], at[other], at[third] = sign, a, b
                ring.append(corner((at[0], at[1], at[2])) * 3 + axis)
            quads.append(ring)
        for other in range(axis + 1, 3):
            third = 3 - axis - other
            for a in (-1, 1):
                for b in (-1, 1):
                    ends = []
                    for c in (-1, 1):
                        at = [0, 0, 0]
                        at[axis], at[other], at[third] = a, b, c
                        ends.append(corner((at[0], at[1], at[2])) * 3)
                    quads.append([ends[0] + axis, ends[1] + axis, ends[1] + other, ends[0] + other])
    for index in range(8):
        corners.append([index * 3, index * 3 + 1, index * 3 + 2])
    triangles = [t for q in quads for t in ([q[0], q[1], q[2]], [q[0], q[2], q[3]])] + corners
    points = (np.repeat(signs, 3, axis=0) * 0.8) + np.tile(np.eye(3), (8, 1)) * np.repeat(
        signs, 3, axis=0
    ) * 0.2
    return signs, _outward(points, np.array(triangles))


@lru_cache(maxsize=1)
def _cube() -> tuple[Mesh, Indices]:
    """A cube with sharp edges from -1 to 1, and the axis across which the face of each vertex lies.

    Slabs are stretched from it, by the hundred: its normals and faces stay what they are.
    """
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=np.float64)
    quads = [(0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5)]
    triangles = [t for q in quads for t in ([q[0], q[1], q[2]], [q[0], q[2], q[3]])]
    cube = shaded(signs, _outward(signs, np.array(triangles)))
    return cube, np.abs(cube.normals).argmax(axis=1)


@lru_cache(maxsize=8)
def _cube_grid(steps: int, split: bool) -> tuple[Floats, Indices]:
    """Points of a cube's surface with `steps` rings beyond 1 and one cell or four inside, and triangles."""
    rim = np.linspace(0, 1, steps + 1)[1:]
    line = np.concatenate([-1 - rim[::-1], [-1, 0, 1] if split else [-1, 1], 1 + rim])
    count = len(line)
    found: dict[tuple[float, ...], int] = {}
    triangles = []
    for axis in range(3):
        first, second = (k for k in range(3) if k != axis)
        for side in (line[0], line[-1]):
            index = np.empty((count, count), dtype=int)
            for i, a in enumerate(line):
                for j, b in enumerate(line):
                    at = [0.0, 0.0, 0.0]
                    at[axis], at[first], at[second] = side, a, b
                    index[i, j] = found.setdefault(tuple(at), len(found))
            for i in range(count - 1):
                for j in range(count - 1):
                    quad = (index[i, j], index[i + 1, j], index[i + 1, j + 1], index[i, j + 1])
                    triangles += [[quad[0], quad[1], quad[2]], [quad[0], quad[2], quad[3]]]
    points = np.array(list(found))
    return points, _outward(points, np.array(triangles))


def _outward(points: Floats, triangles: Indices) -> Indices:
    """Triangles of a convex body around the origin, turned so that they face away from it."""
    corners = points[triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inward = np.einsum("ij,ij->i", normal, corners.mean(axis=1)) < 0
    return np.where(inward[:, None], triangles[:, ::-1], triangles)
