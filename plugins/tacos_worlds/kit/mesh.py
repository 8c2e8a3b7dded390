"""Triangle meshes while a world is being built."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tacos_framework import MeshPart

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Mesh:
    """A triangle mesh with normals and texture coordinates."""

    vertices_m: Floats  # (V, 3) [m]
    normals: Floats  # (V, 3) unit vectors
    uv_m: Floats  # (V, 2) texture coordinates along the surface [m]
    triangles: Indices  # (T, 3) vertex indices, counter-clockwise seen from outside

    def moved(self, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Mesh:
        """The mesh shifted [m]."""
        return Mesh(self.vertices_m + np.array([x, y, z]), self.normals, self.uv_m, self.triangles)

    def turned(self, yaw_rad: float) -> Mesh:
        """The mesh turned about the z axis, counter-clockwise seen from above [rad]."""
        return self.rotated(rotation_z(yaw_rad))

    def rotated(self, rotation: Floats) -> Mesh:
        """The mesh rotated by a (3, 3) matrix about the origin."""
        return Mesh(self.vertices_m @ rotation.T, self.normals @ rotation.T, self.uv_m, self.triangles)

    def with_uv_offset(self, u_m: float, v_m: float) -> Mesh:
        """The mesh with its texture shifted [m], so that equal parts do not look equal."""
        return Mesh(self.vertices_m, self.normals, self.uv_m + np.array([u_m, v_m]), self.triangles)

    def part(self, material: int, object_id: int, light_detail: float = 1.0) -> MeshPart:
        return MeshPart(
            vertices_m=self.vertices_m.astype(np.float32),
            normals=self.normals.astype(np.float32),
            uv_m=self.uv_m.astype(np.float32),
            triangles=self.triangles.astype(np.int32),
            material=material,
            object_id=object_id,
            light_detail=light_detail,
        )


def rotation_z(angle_rad: float) -> Floats:
    """(3, 3) rotation about z."""
    cos, sin = math.cos(angle_rad), math.sin(angle_rad)
    return np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1.0]])


def rotation_x(angle_rad: float) -> Floats:
    """(3, 3) rotation about x."""
    cos, sin = math.cos(angle_rad), math.sin(angle_rad)
    return np.array([[1.0, 0, 0], [0, cos, -sin], [0, sin, cos]])


def rotation_y(angle_rad: float) -> Floats:
    """(3, 3) rotation about y."""
    cos, sin = math.cos(angle_rad), math.sin(angle_rad)
    return np.array([[cos, 0, sin], [0, 1.0, 0], [-sin, 0, cos]])


def merged(meshes: Iterable[Mesh]) -> Mesh:
    meshes = list(meshes)
    first = np.cumsum([0] + [len(mesh.vertices_m) for mesh in meshes[:-1]])
    return Mesh(
        np.concatenate([mesh.vertices_m for mesh in meshes]),
        np.concatenate([mesh.normals for mesh in meshes]),
        np.concatenate([mesh.uv_m for mesh in meshes]),
        np.concatenate([mesh.triangles + start for mesh, start in zip(meshes, first, strict=True)]),
    )


def shaded(
    vertices_m: ArrayLike, triangles: ArrayLike, *, crease_deg: float = 50.0, whole_bevels: bool = False
) -> Mesh:
    """A mesh with smooth normals and box-projected texture coordinates.

    Normals are averaged by area over the faces around a vertex that differ by less than `crease_deg` from
    each other; area weights keep large faces flat beside their bevels. The texture's u axis follows the
    longest dimension of the mesh, as wood grain does. With `whole_bevels` texture coordinates follow the
    normals of vertices instead of faces: fewer vertices, and a seam of texture within each bevel.
    """
    points = np.asarray(vertices_m, dtype=np.float64)
    faces = np.asarray(triangles, dtype=np.int64)
    corners = points[faces]
    area_vectors = _cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    doubled_area = _lengths(area_vectors)
    kept = doubled_area > 1e-10
    if not kept.all():
        faces, area_vectors, doubled_area = faces[kept], area_vectors[kept], doubled_area[kept]
    flat = area_vectors / doubled_area[:, None]

    normals = _corner_normals(faces, area_vectors, flat, math.cos(math.radians(crease_deg)))
    axis = np.abs(normals).argmax(axis=1) if whole_bevels else np.abs(flat).argmax(axis=1).repeat(3)
    code = faces.reshape(-1) * _CODES_PER_VERTEX + axis
    code += (np.rint(normals * 64) @ _CODE_OF_NORMAL).astype(np.int64)
    chosen, index = _distinct(code)
    where = points[faces.reshape(-1)[chosen]]
    return Mesh(where, normals[chosen], box_uv(where, axis[chosen], points), index.reshape(-1, 3))


_NEXT, _AFTER_NEXT = np.array([1, 2, 0]), np.array([2, 0, 1])
_CODE_OF_NORMAL = np.array([3.0 * 129 * 129, 3.0 * 129, 3.0])
"""Makes one number of the components of a normal in 64ths, -64 to 64, with room for an axis below [1]."""
_CODES_PER_VERTEX = 3 * 129**3


def _cross(first: Floats, second: Floats) -> Floats:
    """(N, 3) cross products of (N, 3) vectors, bit for bit as `np.cross`, which takes long to begin."""
    return first.take(_NEXT, axis=1) * second.take(_AFTER_NEXT, axis=1) - first.take(
        _AFTER_NEXT, axis=1
    ) * second.take(_NEXT, axis=1)


def _lengths(vectors: Floats) -> Floats:
    """(N,) lengths of (N, 3) vectors."""
    return np.asarray(np.sqrt(np.add.reduce(vectors * vectors, axis=1)))


def _distinct(code: Indices) -> tuple[Indices, Indices]:
    """First place of each code, in rising order, and (N,) the place of each code in that order."""
    order = code.argsort(kind="stable")
    rising = code[order]
    starts = np.concatenate([[True], rising[1:] != rising[:-1]])
    place = np.empty_like(order)
    place[order] = np.cumsum(starts) - 1
    return order[starts], place


def _corner_normals(faces: Indices, area_vectors: Floats, flat: Floats, cos_crease: float) -> Floats:
    """(3 T, 3) unit normals, one for each corner of each face."""
    corner, other_face, which, (one, other) = _corners_that_meet(faces.tobytes())
    alike = np.einsum("ij,ij->i", flat.take(one, axis=0), flat.take(other, axis=0)) > cos_crease
    meets = alike.take(which).nonzero()[0]
    corner, other_face = corner.take(meets), other_face.take(meets)
    total = np.empty((3 * len(faces), 3))
    for component, area in zip(total.T, area_vectors.T, strict=True):
        component[:] = np.bincount(corner, area.take(other_face))
    return total / _lengths(total)[:, None]


@lru_cache(maxsize=256)
def _corners_that_meet(faces: bytes) -> tuple[Indices, Indices, Indices, tuple[Indices, Indices]]:
    """All ordered pairs of corners that share a vertex.

    Most things are boxes, or turned from equally many points: few lists of faces occur, each many times.

    - `faces`: (T, 3) vertices of faces, as bytes of int64.

    Returns:
    - `corner`: (P,) the one corner of each pair, rising.
    - `other_face`: (P,) the face of the other one; those of one corner rise too.
    - `which`: (P,) the pair of faces that both are of.
    - `pairs`: both faces of each of these, once whatever the order.
    """
    vertex = np.frombuffer(faces, np.int64)
    order = np.argsort(vertex, kind="stable")
    _, group, valence = np.unique(vertex, return_inverse=True, return_counts=True)
    first = np.cumsum(valence) - valence
    others = valence[group]
    corner = np.repeat(np.arange(len(vertex)), others)
    within = np.arange(len(corner)) - np.repeat(np.cumsum(others) - others, others)
    face, other_face = corner // 3, order[np.repeat(first[group], others) + within] // 3
    code = np.minimum(face, other_face) * len(vertex) + np.maximum(face, other_face)
    pairs, which = np.unique(code, return_inverse=True)
    return corner, other_face, which, np.divmod(pairs, len(vertex))


def box_uv(points: Floats, axis: Indices, all_points: Floats) -> Floats:
    """(V, 2) coordinates in the plane across each vertex's axis, u along the longer extent."""
    extent = (all_points.max(axis=0) - all_points.min(axis=0)).tolist()
    planes = np.array([(v, u) if extent[v] > extent[u] else (u, v) for u, v in ((1, 2), (0, 2), (0, 1))])
    return points[np.arange(len(points))[:, None], planes[axis]]
