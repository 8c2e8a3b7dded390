"""Triangle meshes while a world is being built."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tacos_framework.values import MeshPart

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Mesh:
    """A triangle mesh with normals and texture coordinates.

    Parameters
    ----------
    vertices_m
        (V, 3) [m].
    normals
        (V, 3) unit vectors.
    uv_m
        (V, 2) texture coordinates along the surface [m].
    triangles
        (T, 3) vertex indices, counter-clockwise seen from outside.
    """

    vertices_m: Floats
    normals: Floats
    uv_m: Floats
    triangles: Indices

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
        """The mesh as a part of a world; see `MeshPart`."""
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
    """All meshes as one."""
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
    area_vectors = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    doubled_area = np.linalg.norm(area_vectors, axis=1)
    kept = doubled_area > 1e-10
    faces, area_vectors, doubled_area = faces[kept], area_vectors[kept], doubled_area[kept]
    flat = area_vectors / doubled_area[:, None]

    normals = _corner_normals(faces, area_vectors, flat, math.cos(math.radians(crease_deg)))
    axis = np.abs(normals if whole_bevels else np.repeat(flat, 3, axis=0)).argmax(axis=1)
    key = np.concatenate(
        [faces.reshape(-1, 1), np.rint(normals * 64).astype(np.int64), axis[:, None]], axis=1
    )
    code = key[:, 0]
    for column, size in ((1, 129), (2, 129), (3, 129), (4, 3)):
        code = code * size + key[:, column] + (64 if size == 129 else 0)
    _, chosen, index = np.unique(code, return_index=True, return_inverse=True)
    where = points[faces.reshape(-1)[chosen]]
    return Mesh(where, normals[chosen], _box_uv(where, axis[chosen], points), index.reshape(-1, 3))


def _corner_normals(faces: Indices, area_vectors: Floats, flat: Floats, cos_crease: float) -> Floats:
    """(3 T, 3) unit normals, one for each corner of each face."""
    vertex = faces.reshape(-1)
    face = np.repeat(np.arange(len(faces)), 3)
    order = np.argsort(vertex, kind="stable")
    _, first, valence = np.unique(vertex[order], return_index=True, return_counts=True)
    # All ordered pairs of corners that share a vertex.
    per_corner = np.repeat(valence, valence)
    left = np.repeat(np.arange(len(order)), per_corner)
    within = np.arange(len(left)) - np.repeat(np.cumsum(per_corner) - per_corner, per_corner)
    right = np.repeat(np.repeat(first, valence), per_corner) + within
    left_corner, right_corner = order[left], order[right]
    alike = np.einsum("ij,ij->i", flat[face[left_corner]], flat[face[right_corner]]) > cos_crease
    left_corner, right_face = left_corner[alike], face[right_corner[alike]]
    total = np.stack(
        [np.bincount(left_corner, area_vectors[right_face, k], minlength=len(vertex)) for k in range(3)],
        axis=1,
    )
    return total / np.linalg.norm(total, axis=1, keepdims=True)


def _box_uv(points: Floats, axis: Indices, all_points: Floats) -> Floats:
    """(V, 2) coordinates in the plane across each vertex's axis, u along the longer extent."""
    extent = np.ptp(all_points, axis=0)
    uv = np.empty((len(points), 2))
    for normal_axis in range(3):
        chosen = axis == normal_axis
        first, second = (k for k in range(3) if k != normal_axis)
        if extent[second] > extent[first]:
            first, second = second, first
        uv[chosen, 0] = points[chosen, first]
        uv[chosen, 1] = points[chosen, second]
    return uv
