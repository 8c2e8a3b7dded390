"""Meshes as trimesh measures them."""

from __future__ import annotations

import trimesh

from tacos_worlds.kit.mesh import Mesh


def solid(mesh: Mesh) -> trimesh.Trimesh:
    """The geometry with coincident vertices merged."""
    found = trimesh.Trimesh(mesh.vertices_m, mesh.triangles, process=False)
    found.merge_vertices(merge_tex=True, merge_norm=True)
    return found
