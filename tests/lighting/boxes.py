"""Small worlds with known light."""

from __future__ import annotations

import numpy as np
import trimesh

from tacos_framework.values import Light, Material, MeshPart, Object, World


def world_of(mesh: trimesh.Trimesh | None, reflectance: float = 0.5, lights: tuple[Light, ...] = ()) -> World:
    """A world of one flat-shaded grey mesh, or of nothing."""
    parts: tuple[MeshPart, ...] = ()
    if mesh is not None:
        corners = mesh.triangles.reshape(-1, 3)
        parts = (
            MeshPart(
                corners,
                np.repeat(mesh.face_normals, 3, axis=0),
                np.zeros((len(corners), 2)),
                np.arange(len(corners)).reshape(-1, 3),
                0,
                0,
            ),
        )
    return World(
        key="test",
        parts=parts,
        materials=(Material("grey", np.full(3, reflectance)),),
        objects=(Object("background", "background"),),
        class_names=("background",),
        lights=lights,
    )


def panel_light(half_u: float, half_v: float, height: float, flux_lm: float) -> Light:
    """A rectangle that shines down from a height above the origin."""
    return Light(
        np.array([0, 0, height]),
        np.full(3, flux_lm),
        normal=np.array([0, 0, -1.0]),
        half_u_m=np.array([half_u, 0, 0]),
        half_v_m=np.array([0, half_v, 0]),
    )


def ceiling(half: float, height: float) -> trimesh.Trimesh:
    """A square that faces down."""
    corners = [[-half, -half, height], [half, -half, height], [half, half, height], [-half, half, height]]
    return trimesh.Trimesh(corners, [[0, 2, 1], [0, 3, 2]], process=False)
