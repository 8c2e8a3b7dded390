"""The scene `scene.slanted-edges`: dark squares, a little turned, all over the view."""

from __future__ import annotations

import math

import numpy as np

from tacos_framework import Episode, MeshPart, Settings, setting
from tacos_worlds.bench.stand import matte, square, standing, tent_world

IN_FRONT_M = 1e-4
"""How far the squares lie before the paper, so that neither hides the other by chance [m]."""


class SlantedEdges:
    """Dark squares on white paper, turned by a few degrees: straight edges of two directions everywhere.

    Edges that lie a little aslant to the pixels sample the blur of a lens more finely than the pixels do.

    Source: ISO 12233, slanted-edge method.
    """

    class Config(Settings):
        angle_deg: float = setting(
            5.0, help="Angle of the edges to the image's axes.", unit="deg", ge=-45, le=45
        )
        pitch_m: float = setting(0.03, help="From square to square.", unit="m", gt=0)
        square: float = setting(0.5, help="Side of a square over the pitch.", gt=0, lt=1)
        dark: float = setting(0.1, help="Reflectance of the squares.", ge=0, le=1)
        white: float = setting(0.9, help="Reflectance of the paper.", gt=0, le=1)
        size_m: float = setting(0.6, help="Edge of the square sheet of paper.", unit="m", gt=0)
        distance_m: float = setting(0.5, help="From the camera to the target.", unit="m", gt=0)
        frames: int = setting(1, help="Frames taken.", ge=1, le=1_000_000)

    def __init__(self, config: Config) -> None:
        self.config = config

    def episode(self, *, illumination_lux: float) -> Episode:
        config = self.config
        paper = square(config.distance_m, config.size_m / 2)
        world = tent_world(
            f"scene.slanted-edges {config.model_dump(exclude={'frames'})!r}",
            [paper, self._squares()],
            [matte("paper", config.white), matte("squares", config.dark)],
            illumination_lux=illumination_lux,
        )
        return standing(world, config.frames)

    def _squares(self) -> MeshPart:
        config = self.config
        reach = int(config.size_m / 2 / config.pitch_m - 0.5)
        places = np.arange(-reach, reach + 1) * config.pitch_m
        centres = np.stack(np.meshgrid(places, places), axis=-1).reshape(-1, 1, 2)
        angle, half_m = math.radians(config.angle_deg), config.square * config.pitch_m / 2
        u = half_m * np.array([math.cos(angle), math.sin(angle)])
        v = half_m * np.array([-math.sin(angle), math.cos(angle)])
        corners = (centres + np.array([-u - v, u - v, u + v, -u + v])).reshape(-1, 2)  # right, up
        vertices = np.column_stack(
            [np.full(len(corners), config.distance_m - IN_FRONT_M), -corners[:, 0], corners[:, 1]]
        )
        firsts = 4 * np.arange(len(corners) // 4)[:, None]
        return MeshPart(
            vertices_m=vertices.astype(np.float32),
            normals=np.tile(np.array([-1, 0, 0], np.float32), (len(corners), 1)),
            uv_m=corners.astype(np.float32),
            triangles=np.concatenate(
                [firsts + np.array(triangle) for triangle in ((0, 1, 2), (0, 2, 3))]
            ).astype(np.int32),
            material=1,
            object_id=1,
        )
