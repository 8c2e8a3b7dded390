"""A shelf with QR codes, and a way past it."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray
from tacos_framework import Episode, Light, Material, MeshPart, Object, Settings, Trajectory, World, setting

CLASS_NAME = "qr-code"
"""Class of the objects that are labels; each is called by what its code says."""
HEIGHT_M, DEPTH_M, LIFT_M = 2.5, 3.0, 0.002
ROWS_M = (1.25, 1.5, 1.75)
TEXTURE_PX = 512


class QrShelf:
    """The agent looks at a shelf and passes it from left to right; what the codes say is drawn.

    The boxes of the shelf are its front alone, a plane; labels hang at three heights, shifted at random.
    """

    class Config(Settings):
        """Settings of the scene."""

        frames: int = setting(12, help="Frames of an episode.", ge=1)
        columns: int = setting(4, help="Labels side by side, at each of three heights.", ge=1, le=50)
        label_m: float = setting(0.08, help="Edge of a label, white rim included.", unit="m", gt=0, le=0.3)
        distance_m: float = setting(1.2, help="From the eye to the shelf.", unit="m", gt=0.1, le=2.5)
        speed_m_s: float = setting(1.0, help="Speed at which the shelf is passed.", unit="m/s", gt=0)

    def __init__(self, config: Config) -> None:
        self.config = config

    def episode(self, *, rng: np.random.Generator, illumination_lux: float) -> Episode:
        """One way past all labels."""
        config = self.config
        length_m = 0.5 * config.columns
        poses = np.tile(np.eye(4), (2, 1, 1))
        poses[:, :3, 3] = [[0, length_m / 2, 1.5], [0, -length_m / 2, 1.5]]
        end_s = length_m / config.speed_m_s
        return Episode(
            world=self._world(rng, length_m, illumination_lux),
            trajectory=Trajectory(np.array([0.0, end_s]), poses),
            time_s=np.linspace(0, end_s, config.frames + 1)[:-1],
            walk=np.zeros(config.frames, np.int32),
        )

    def _world(self, rng: np.random.Generator, length_m: float, illumination_lux: float) -> World:
        config, shelf_x, half = self.config, self.config.distance_m, self.config.label_m / 2
        count = 3 * config.columns
        texts = [f"BOX-{number:06d}" for number in rng.choice(1_000_000, count, replace=False)]
        shifts_m = rng.uniform(-0.1, 0.1, count)
        wide, deep, up = length_m, DEPTH_M / 2, HEIGHT_M / 2
        middle = shelf_x - deep
        parts = [
            rectangle((middle, 0, 0), (deep, 0, 0), (0, wide, 0), 0, 0),
            rectangle((middle, 0, HEIGHT_M), (0, wide, 0), (deep, 0, 0), 0, 0),
            rectangle((shelf_x, 0, up), (0, -wide, 0), (0, 0, up), 0, 0),
        ]
        for i, shift_m in enumerate(shifts_m):
            centre = (shelf_x - LIFT_M, 0.5 * (i // 3 + 0.5) - length_m / 2 + shift_m, ROWS_M[i % 3])
            parts.append(rectangle(centre, (0, -half, 0), (0, 0, half), 1 + i, 1 + i))
        drawn = (ROWS_M, texts, shifts_m.tolist(), illumination_lux)
        return World(
            key=f"tacos_qr_codes.shelf {config.model_dump_json()} {drawn!r}",
            parts=tuple(parts),
            materials=(Material("board", np.full(3, 0.5)), *(printed(text, 2 * half) for text in texts)),
            objects=(Object("background", "background"), *(Object(text, CLASS_NAME) for text in texts)),
            class_names=("background", CLASS_NAME),
            lights=(_lamp(middle, wide, illumination_lux),),
        )


def _lamp(middle_m: float, half_length_m: float, illumination_lux: float) -> Light:
    """A luminous strip below the ceiling; its flux by the lumen method, half of it used."""
    return Light(
        position_m=np.array([middle_m, 0, HEIGHT_M - LIFT_M]),
        flux_lm=np.full(3, illumination_lux * DEPTH_M * 2 * half_length_m / 0.5),
        normal=np.array([0, 0, -1]),
        half_u_m=np.array([0.1, 0, 0]),
        half_v_m=np.array([0, half_length_m, 0]),
    )


def code_image(text: str) -> NDArray[np.uint8]:
    """(H, H) a QR code with its quiet zone of four modules, one pixel a module, row 0 at the top."""
    return np.pad(cv2.QRCodeEncoder.create().encode(text), 2, constant_values=255)  # OpenCV leaves two


def printed(text: str, edge_m: float) -> Material:
    """Matt paper with a QR code; row 0 of a texture is its bottom."""
    large = cv2.resize(code_image(text), (TEXTURE_PX, TEXTURE_PX), interpolation=cv2.INTER_NEAREST)
    ink = np.where(large > 127, 240, 25).astype(np.uint8)[::-1]
    return Material(
        text, np.ones(3), texture=np.repeat(ink[..., None], 3, axis=2), texture_size_m=edge_m, roughness=0.9
    )


def rectangle(
    centre_m: Sequence[float], half_u_m: Sequence[float], half_v_m: Sequence[float], material: int, thing: int
) -> MeshPart:
    """A rectangle that faces ``half_u x half_v``, which lead from its centre to two of its edges [m]."""
    centre, u, v = (np.array(vector, np.float64) for vector in (centre_m, half_u_m, half_v_m))
    width_m, height_m = 2 * np.linalg.norm(u), 2 * np.linalg.norm(v)
    return MeshPart(
        vertices_m=np.array([centre - u - v, centre + u - v, centre + u + v, centre - u + v]),
        normals=np.tile(np.cross(u, v) / np.linalg.norm(np.cross(u, v)), (4, 1)),
        uv_m=np.array([[0, 0], [width_m, 0], [width_m, height_m], [0, height_m]]),
        triangles=np.array([[0, 1, 2], [0, 2, 3]]),
        material=material,
        object_id=thing,
    )
