"""A world as users have it, made by trimesh."""

from __future__ import annotations

import numpy as np
import trimesh

ROOM_M = (6.0, 4.0, 2.6)


def two_rooms() -> trimesh.Scene:
    """Two rooms of thin walls joined by a door with a threshold, a sofa and a crate; z up."""
    length, width, height = ROOM_M
    scene = trimesh.Scene()

    def box(name: str, lower: tuple[float, ...], upper: tuple[float, ...], colour: tuple[int, ...]) -> None:
        extent = np.subtract(upper, lower)
        mesh = trimesh.creation.box(extent)
        mesh.apply_translation(np.add(lower, upper) / 2)
        material = trimesh.visual.material.PBRMaterial(name=name, baseColorFactor=(*colour, 255))
        mesh.visual = trimesh.visual.TextureVisuals(uv=np.zeros((len(mesh.vertices), 2)), material=material)
        scene.add_geometry(mesh, node_name=name, geom_name=f"mesh of {name}")

    box("floor", (0, 0, -0.1), (length, width, 0), (140, 100, 70))
    box("ceiling", (0, 0, height), (length, width, height + 0.1), (220, 220, 220))
    for name, lower, upper in (
        ("wall 1", (0, -0.1, 0), (length, 0, height)),
        ("wall 2", (0, width, 0), (length, width + 0.1, height)),
        ("wall 3", (-0.1, 0, 0), (0, width, height)),
        ("wall 4", (length, 0, 0), (length + 0.1, width, height)),
        ("wall 5", (2.95, 0, 0), (3.05, 1.5, height)),
        ("wall 6", (2.95, 2.5, 0), (3.05, width, height)),
        ("wall 7", (2.95, 1.5, 2.1), (3.05, 2.5, height)),
    ):
        box(name, lower, upper, (200, 195, 185))
    box("door_sill", (2.9, 1.5, 0), (3.1, 2.5, 0.02), (180, 160, 60))
    box("Sofa.001", (0.1, 0.1, 0), (1.9, 0.9, 0.8), (60, 80, 140))
    box("thing 7", (5.2, 3.2, 0), (5.9, 3.9, 0.7), (90, 60, 30))
    return scene


def y_up(scene: trimesh.Scene) -> trimesh.Scene:
    """As glTF wants it."""
    turned = scene.copy()
    turned.apply_transform(np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]]))
    return turned
