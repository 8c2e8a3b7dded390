"""A straight corridor with a checkerboard at its far end."""

from __future__ import annotations

import math

import numpy as np
from tacos_framework import Episode, Light, Material, MeshPart, Object, Settings, Trajectory, World, setting

MATERIALS = (("wall", 0.7), ("floor", 0.3), ("white", 0.85), ("black", 0.04))
"""Names and reflectances [1]; parts name them by position."""
WALL, FLOOR, WHITE, BLACK = range(len(MATERIALS))
BOARD_ID = 1
BOARD_SQUARES = (8, 6)
MARGIN_SQUARES = 1
LIFT_M = 0.001  # keeps a surface clear of the one behind it


class Corridor:
    """An agent walks at constant speed towards a checkerboard; the corridor's length is drawn."""

    class Config(Settings):
        frames: int = setting(12, help="Frames of an episode.", ge=1)
        length_m: tuple[float, float] = setting((6.0, 12.0), help="Range of the length.", unit="m")
        width_m: float = setting(2.0, help="Distance of the side walls.", unit="m", gt=0.5)
        height_m: float = setting(2.5, help="Height of the ceiling.", unit="m", gt=1)
        eye_m: float = setting(1.5, help="Height of the agent's eye.", unit="m", gt=0)
        square_m: float = setting(0.1, help="Edge of a square of the board.", unit="m", gt=0, le=0.15)

    def __init__(self, config: Config) -> None:
        self.config = config

    def episode(self, *, rng: np.random.Generator, illumination_lux: float) -> Episode:
        """One walk, up to a metre from the board."""
        config = self.config
        length_m = float(rng.uniform(*config.length_m))
        end_s = length_m - 1.0  # at 1 m/s
        poses = np.tile(np.eye(4), (2, 1, 1))
        poses[:, :3, 3] = [[0, 0, config.eye_m], [end_s, 0, config.eye_m]]
        return Episode(
            world=self._world(length_m, illumination_lux),
            trajectory=Trajectory(np.array([0.0, end_s]), poses),
            time_s=np.linspace(0, end_s, config.frames + 1)[:-1],
            walk=np.zeros(config.frames, np.int32),
        )

    def _world(self, length_m: float, illumination_lux: float) -> World:
        config = self.config
        middle, half, up = length_m / 2, config.width_m / 2, config.height_m / 2
        along, across, upright = (middle, 0, 0), (0, half, 0), (0, 0, up)
        parts = [
            rectangle((middle, 0, 0), along, across, FLOOR),
            rectangle((middle, 0, 2 * up), across, along, WALL),
            rectangle((middle, half, up), along, upright, WALL),
            rectangle((middle, -half, up), upright, along, WALL),
            rectangle((length_m, 0, up), upright, across, WALL),
            *self._board(length_m),
        ]
        return World(
            key=f"tacos_example.corridor {config.model_dump_json()} {length_m!r} {illumination_lux!r}",
            parts=tuple(parts),
            materials=tuple(Material(name, np.full(3, value)) for name, value in MATERIALS),
            objects=(Object("background", "background"), Object("board", "checkerboard")),
            class_names=("background", "checkerboard"),
            lights=(self._lamp(length_m, illumination_lux),),
        )

    def _lamp(self, length_m: float, illumination_lux: float) -> Light:
        """A luminous strip below the ceiling; its flux by the lumen method, half of it used."""
        flux_lm = illumination_lux * length_m * self.config.width_m / 0.5
        return Light(
            position_m=np.array([length_m / 2, 0, self.config.height_m - LIFT_M]),
            flux_lm=np.full(3, flux_lm),
            normal=np.array([0, 0, -1]),
            half_u_m=np.array([length_m / 2, 0, 0]),
            half_v_m=np.array([0, 0.05, 0]),
        )

    def _board(self, length_m: float) -> list[MeshPart]:
        square, (columns, rows) = self.config.square_m, BOARD_SQUARES
        half = square / 2

        def piece(y: float, z: float, half_y: float, half_z: float, layer: int, material: int) -> MeshPart:
            centre = (length_m - layer * LIFT_M, y, self.config.eye_m + z)
            return rectangle(centre, (0, 0, half_z), (0, half_y, 0), material, BOARD_ID)

        sheet_y, sheet_z = (half * (count + 2 * MARGIN_SQUARES) for count in BOARD_SQUARES)
        squares = [
            piece(
                (column - (columns - 1) / 2) * square, (row - (rows - 1) / 2) * square, half, half, 2, BLACK
            )
            for column in range(columns)
            for row in range(rows)
            if (column + row) % 2 == 0
        ]
        return [piece(0, 0, sheet_y, sheet_z, 1, WHITE), *squares]


def rectangle(
    centre_m: tuple[float, float, float],
    half_u_m: tuple[float, float, float],
    half_v_m: tuple[float, float, float],
    material: int,
    object_id: int = 0,
) -> MeshPart:
    """A rectangle that faces ``half_u x half_v``.

    `centre_m`: its centre [m]. `half_u_m`, `half_v_m`: from the centre to the middle of two edges [m].
    """
    centre, u, v = (np.array(vector, np.float64) for vector in (centre_m, half_u_m, half_v_m))
    normal = np.cross(u, v)
    width_m, height_m = 2 * math.dist(u, (0, 0, 0)), 2 * math.dist(v, (0, 0, 0))
    return MeshPart(
        vertices_m=np.array([centre - u - v, centre + u - v, centre + u + v, centre - u + v]),
        normals=np.tile(normal / np.linalg.norm(normal), (4, 1)),
        uv_m=np.array([[0, 0], [width_m, 0], [width_m, height_m], [0, height_m]]),
        triangles=np.array([[0, 1, 2], [0, 2, 3]]),
        material=material,
        object_id=object_id,
    )
