"""Attributes of vertices, and those that each kind of surface is shaded by."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tacos_plugins.renderers.light.baked_mesh import BakedMesh
from tacos_plugins.renderers.light.flatten import SurfaceKind
from tacos_plugins.renderers.software import pixel_batch as row


def of_vertices(lit: BakedMesh) -> NDArray[np.float32]:
    """(V, ATTRIBUTES) what each vertex says, in the order of the rows of a `PixelBatch`."""
    mesh, light = lit.mesh, lit.vertex_light
    columns = (
        mesh.uv,
        lit.map_coordinates,
        light.luminance_cd_m2,
        light.bend,
        mesh.normal,
        lit.tangents,
        light.unshadowed_share,
    )
    return np.ascontiguousarray(np.column_stack(columns), np.float32)


def rows_of(kind: SurfaceKind) -> NDArray[np.int64]:
    """The rows of a `PixelBatch` that a kind of surface gets from its vertices."""
    mapped, bumpy = SurfaceKind.MAPPED in kind, SurfaceKind.BUMPY in kind
    rows = [row.MAP_U, row.MAP_V] if mapped else [row.RED, row.GREEN, row.BLUE]
    if bumpy or SurfaceKind.TEXTURED in kind:
        rows += [row.U, row.V]
    if bumpy and not mapped:
        rows += [row.BEND_U, row.BEND_V]
    if SurfaceKind.GLOSSY in kind:
        rows += [row.NORMAL_X, row.NORMAL_Y, row.NORMAL_Z]
        rows += [row.TANGENT_X, row.TANGENT_Y, row.TANGENT_Z, row.SIDE] if bumpy else []
        rows += [] if mapped else [row.SHARE]
    return np.array(rows, np.int64)
