"""A house at UTM coordinates as exporters write it: glass, a fence with holes, vertex colours, labels."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh
from PIL import Image

UTM_M = np.array([448262.37, 5411932.61, 212.0])
TABLE_M = ((3.0, 2.4, 0.0), (4.2, 3.2, 0.75))


def _material(name: str, colour: tuple[int, ...], **more: object) -> trimesh.visual.material.PBRMaterial:
    look = {"baseColorFactor": colour, "metallicFactor": 0.0, "roughnessFactor": 0.8, **more}
    return trimesh.visual.material.PBRMaterial(name=name, **look)


def _fence() -> trimesh.Trimesh:
    bars = np.full((64, 64, 4), (90, 60, 30, 0), np.uint8)
    bars[:, ::4, 3] = bars[:4, :, 3] = 255
    corners = np.array([[6, 0.5, 0], [6, 3.5, 0], [6, 3.5, 1.2], [6, 0.5, 1.2]], float)
    fence = trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]], process=False)
    picture = Image.fromarray(bars)
    look = _material(
        "fence", (255, 255, 255, 255), baseColorTexture=picture, alphaMode="MASK", alphaCutoff=0.5
    )
    fence.visual = trimesh.visual.TextureVisuals(uv=[[0, 0], [2, 0], [2, 1], [0, 1]], material=look)
    return fence


def glass_house(file: Path) -> Path:
    """Write a house of 10 x 6 x 2.8 m as GLB, y up, its node far from the origin; z is up in `UTM_M`."""
    scene = trimesh.Scene()
    y_up = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
    away = trimesh.transformations.translation_matrix(UTM_M)

    def add(name: str, mesh: trimesh.Trimesh) -> None:
        scene.add_geometry(mesh, node_name=name, geom_name=name, transform=y_up @ away)

    def box(name: str, low: tuple[float, ...], high: tuple[float, ...], look: object) -> None:
        mesh = trimesh.creation.box(bounds=[low, high])
        mesh.visual = trimesh.visual.TextureVisuals(uv=np.zeros((len(mesh.vertices), 2)), material=look)
        add(name, mesh)

    white, grey = _material("plaster", (220, 220, 210, 255)), _material("stone", (130, 120, 110, 255))
    rng = np.random.default_rng(1)
    floor = trimesh.creation.box(bounds=[(0, 0, -0.1), (10, 6, 0)]).subdivide().subdivide().subdivide()
    shade = np.column_stack(
        [rng.integers(60, 250, (len(floor.vertices), 3)), np.full(len(floor.vertices), 255)]
    )
    floor.visual = trimesh.visual.ColorVisuals(floor, vertex_colors=shade.astype(np.uint8))
    add("floor", floor)
    box("ceiling", (0, 0, 2.8), (10, 6, 2.9), white)
    for name, low, high in (
        ("wall south", (0, -0.1, 0), (10, 0, 2.8)),
        ("wall north", (0, 6, 0), (10, 6.1, 2.8)),
        ("wall west", (-0.1, 0, 0), (0, 6, 2.8)),
        ("wall east", (10, 0, 0), (10.1, 6, 2.8)),
    ):
        box(name, low, high, white)
    box("Table", *TABLE_M, grey)
    box("door sill", (7.4, 1.5, 0), (7.6, 4.5, 0.04), grey)
    box("pane", (4.98, 0, 0), (5.02, 2.5, 2.8), _material("glass", (200, 220, 255, 40), alphaMode="BLEND"))
    add("fence", _fence())
    scene.export(file)
    return file
