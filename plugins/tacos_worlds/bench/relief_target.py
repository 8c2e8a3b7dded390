"""The scene `scene.relief-target`: blocks of detail at several depths before a wall, passed sideways."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise, product

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Episode, Material, MeshPart, Settings, Trajectory, setting
from tacos_worlds.bench.stand import FRAME_INTERVAL_S, bench_world, matte, standing
from tacos_worlds.bench.textured_target import dead_leaves

MESH_M = 0.01
"""Edge of the triangles of the target, as fine as its shadows: light is worked out at corners [m]."""

WALL_MESH_M = 0.05
WALL, LEAVES = 0, 1
BACKGROUND_ID, TARGET_ID = 0, 1


class ReliefTarget:
    """A square of blocks that stand out by different heights, covered with detail of all sizes.

    The detail is that of `scene.textured-target`. The blocks give it depth, so that two views of it are
    related by their epipolar geometry alone and no plane explains them; a plain wall behind adds no features.
    A panel of light above the camera casts soft shadows, and light goes to and fro between the blocks.

    The camera passes sideways at even steps, the middle of its way before the middle of the target. What
    moves is the camera, not the target: the light stays with the target, so frames differ by the view alone.

    Source: The paper, Sec. 4.1 (Perception Task Performance) and the supplement: a target with features of
    varying scales and depths before a textureless background, taken at ten places along a line. Its target is
    that of Dansereau, Girod and Wetzstein 2019, "LiFF: Light field features in scale and depth", CVPR.
    """

    class Config(Settings):
        size_m: float = setting(0.4, help="Edge of the target.", unit="m", gt=0)
        blocks: int = setting(5, help="Blocks along an edge.", ge=1, le=32)
        relief_m: float = setting(0.1, help="Height of the highest block.", unit="m", ge=0)
        distance_m: float = setting(
            0.6, help="From the camera to the front of the highest block.", unit="m", gt=0.1
        )
        way_m: float = setting(0.2, help="From the first place of the camera to the last.", unit="m", ge=0)
        wall_behind_m: float = setting(0.3, help="From the back of the target to the wall.", unit="m", gt=0)
        wall_m: float = setting(4.0, help="Edge of the wall.", unit="m", gt=0)
        wall_reflectance: float = setting(0.5, help="Reflectance of the wall.", ge=0, le=1)
        darkest: float = setting(0.05, help="Least reflectance of the detail.", ge=0, le=1)
        brightest: float = setting(0.9, help="Greatest reflectance of the detail.", gt=0, le=1)
        roughness: float = setting(1.0, help="Roughness of the target; 0.8 or more is matte.", ge=0, le=1)
        texture_px: int = setting(
            2048, help="Edge of the texture; a power of two.", unit="px", ge=64, le=8192
        )
        frames: int = setting(10, help="Places along the way.", ge=1, le=10_000)

    def __init__(self, config: Config) -> None:
        self.config = config

    def episode(self, *, rng: np.random.Generator, illumination_lux: float) -> Episode:
        """The target, and a frame from each place.

        `illumination_lux`: mean illuminance on the front of the target [lux].
        """
        config = self.config
        number = int(rng.integers(2**32))
        drawn = np.random.default_rng(number)
        heights = drawn.permuted(np.linspace(0, config.relief_m, config.blocks**2))
        detail = Material(
            "detail",
            np.ones(3, np.float32),
            texture=dead_leaves(drawn, config.texture_px, config.darkest, config.brightest),
            texture_size_m=config.size_m,
            roughness=config.roughness,
        )
        world = bench_world(
            f"scene.relief-target {number} {config.model_dump(exclude={'way_m', 'frames', 'distance_m'})!r}",
            [self._wall(), *self._blocks(heights.reshape(config.blocks, config.blocks))],
            [matte("wall", config.wall_reflectance), detail],
            illumination_lux=illumination_lux,
            distance_m=config.distance_m,
            width_m=config.size_m,
            height_m=config.size_m,
            reflections=True,
        )
        return self._passing(standing(world, config.frames))

    def _passing(self, still: Episode) -> Episode:
        """The same frames from places along the way, to the left: the target goes right."""
        poses = np.tile(np.eye(4), (2, 1, 1))
        poses[:, 1, 3] = np.array([-0.5, 0.5]) * self.config.way_m
        last_s = max(len(still) - 1, 1) * FRAME_INTERVAL_S
        way = Trajectory(np.array([0.0, last_s]), poses)
        return Episode(still.world, way, still.time_s, still.walk)

    def _wall(self) -> MeshPart:
        config = self.config
        x = config.distance_m + config.relief_m + config.wall_behind_m
        half = np.array([0.0, 0.0, config.wall_m / 2]), np.array([0.0, config.wall_m / 2, 0.0])
        return rectangle(np.array([x, 0.0, 0.0]), *half, WALL, BACKGROUND_ID, WALL_MESH_M)

    def _blocks(self, heights_m: NDArray[np.float64]) -> Iterator[MeshPart]:
        """Front and sides of every block, rows from the top; sides where a block stands above the back."""
        config = self.config
        back = config.distance_m + config.relief_m
        edges = np.linspace(-config.size_m / 2, config.size_m / 2, config.blocks + 1)
        spans = list(pairwise(edges))
        for (row, (low, high)), (column, (right, left)) in product(enumerate(spans), enumerate(spans)):
            height = float(heights_m[row, column])
            y, z = np.array([0, (left - right) / 2, 0]), np.array([0, 0, (high - low) / 2])
            front = np.array([back - height, (right + left) / 2, (low + high) / 2])
            yield rectangle(front, z, y, LEAVES, TARGET_ID, MESH_M)
            if height > 0:
                x = np.array([height / 2, 0, 0])
                yield rectangle(front + x + y, x, z, LEAVES, TARGET_ID, MESH_M, flipped=True)
                yield rectangle(front + x - y, x, z, LEAVES, TARGET_ID, MESH_M)
                yield rectangle(front + x + z, x, y, LEAVES, TARGET_ID, MESH_M)
                yield rectangle(front + x - z, x, y, LEAVES, TARGET_ID, MESH_M, flipped=True)


def rectangle(
    centre_m: NDArray[np.float64],
    half_u_m: NDArray[np.float64],
    half_v_m: NDArray[np.float64],
    material: int,
    object_id: int,
    mesh_m: float,
    *,
    flipped: bool = False,
) -> MeshPart:
    """A rectangle cut into small triangles, which faces along u x v, or against it where `flipped`.

    `centre_m`, `half_u_m`, `half_v_m`: (3,) middle, and from there to the middles of two edges [m]. `mesh_m`:
    edge of a cell at most [m].
    """
    counts = [int(np.ceil(2 * np.linalg.norm(half) / mesh_m)) for half in (half_u_m, half_v_m)]
    u, v = (np.linspace(-1, 1, count + 1) for count in counts)
    grid_u, grid_v = (each.ravel() for each in np.meshgrid(u, v, indexing="ij"))
    vertices = centre_m + np.outer(grid_u, half_u_m) + np.outer(grid_v, half_v_m)
    corner = (np.arange(counts[0])[:, None] * (counts[1] + 1) + np.arange(counts[1])).ravel()
    over, across = corner + counts[1] + 1, corner + 1
    beyond = over + 1
    triangles = np.concatenate([np.stack([corner, over, beyond], 1), np.stack([corner, beyond, across], 1)])
    normal = np.cross(half_u_m, half_v_m)
    normal /= np.linalg.norm(normal) * (-1 if flipped else 1)
    along = [int(np.argmax(np.abs(half))) for half in (half_u_m, half_v_m)]
    return MeshPart(
        vertices_m=vertices.astype(np.float32),
        normals=np.tile(normal.astype(np.float32), (len(vertices), 1)),
        uv_m=vertices[:, along].astype(np.float32),
        triangles=(triangles[:, ::-1] if flipped else triangles).astype(np.int32),
        material=material,
        object_id=object_id,
    )
