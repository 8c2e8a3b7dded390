"""Frames along a mesh's surfaces in which normal maps are meant."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tacos_plugins.renderers.light.flatten import FlatMesh


def tangent_frames(mesh: FlatMesh) -> NDArray[np.float32]:
    """(V, 2, 3) unit tangent (along u) and bitangent (along v) at each vertex, square to its normal [1].

    Where texture coordinates do not change along the surface, any pair square to the normal is given.
    """
    corners, uv = mesh.corners_m.astype(np.float64), mesh.uv[mesh.triangles].astype(np.float64)
    edge, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    (du, dv), (eu, ev) = (uv[:, 1] - uv[:, 0]).T, (uv[:, 2] - uv[:, 0]).T
    side = np.sign(du * ev - eu * dv)[:, None]  # mirrored texture coordinates turn the frame
    along_u = (edge * ev[:, None] - other * dv[:, None]) * side
    along_v = (other * du[:, None] - edge * eu[:, None]) * side
    tangent = _square_to(mesh.normal, mesh.summed_at_vertices(along_u), fallback=_any_square_to(mesh.normal))
    bitangent = np.cross(mesh.normal, tangent)
    mirrored = np.einsum("ij,ij->i", bitangent, mesh.summed_at_vertices(along_v)) < 0
    bitangent[mirrored] *= -1
    return np.stack([tangent, bitangent], axis=1).astype(np.float32)


def _square_to(
    normal: NDArray[np.float32], vector: NDArray[np.float64], fallback: NDArray[np.float64]
) -> NDArray[np.float64]:
    scale = np.linalg.norm(vector, axis=1, keepdims=True)
    vector = vector / np.maximum(scale, 1e-30)
    square = vector - np.einsum("ij,ij->i", vector, normal)[:, None] * normal
    length = np.linalg.norm(square, axis=1, keepdims=True)
    usable = (length > 1e-3) & (scale > 1e-30)
    return np.where(usable, square / np.maximum(length, 1e-30), fallback)


def _any_square_to(normal: NDArray[np.float32]) -> NDArray[np.float64]:
    guide = np.where(np.abs(normal[:, 2:3]) < 0.9, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
    square = np.cross(guide, normal.astype(np.float64))
    return square / np.maximum(np.linalg.norm(square, axis=1, keepdims=True), 1e-12)
