"""The scene `scene.chessboard`: a calibration board, tilted and turned."""

from __future__ import annotations

from itertools import product

from tacos_framework import Episode, Settings, setting
from tacos_worlds.bench.stand import facing, matte, standing, tent_world, turned

IN_FRONT_M = 1e-4
"""How far the squares lie before the paper [m]."""


class Chessboard:
    """A chessboard on white paper with a margin of one square, as calibration tools expect it."""

    class Config(Settings):
        inner_corners: tuple[int, int] = setting((9, 6), help="Inner corners along its rows and columns.")
        square_mm: float = setting(25.0, help="Side of its squares.", unit="mm", gt=0)
        distance_m: float = setting(0.6, help="From the camera to its middle.", unit="m", gt=0)
        right_m: float = setting(0.0, help="Distance to the right of the axis.", unit="m")
        up_m: float = setting(0.0, help="Height above the axis.", unit="m")
        tilt_deg: float = setting(
            0.0, help="Turn about the horizontal; above 0 its top goes back.", unit="deg", ge=-80, le=80
        )
        turn_deg: float = setting(
            0.0, help="Turn about the vertical; above 0 its right goes back.", unit="deg", ge=-80, le=80
        )
        black: float = setting(0.04, help="Reflectance of the black squares.", ge=0, le=1)
        white: float = setting(0.9, help="Reflectance of the paper.", gt=0, le=1)
        frames: int = setting(1, help="Frames taken.", ge=1, le=1_000_000)

    def __init__(self, config: Config) -> None:
        self.config = config

    def episode(self, *, illumination_lux: float) -> Episode:
        config = self.config
        columns, rows = (count + 1 for count in config.inner_corners)
        side_m = config.square_mm * 1e-3
        left_m, bottom_m = config.right_m - columns * side_m / 2, config.up_m - rows * side_m / 2
        paper = facing(
            config.distance_m,
            (left_m - side_m, left_m + (columns + 1) * side_m),
            (bottom_m - side_m, bottom_m + (rows + 1) * side_m),
        )
        squares = [
            facing(
                config.distance_m - IN_FRONT_M,
                (left_m + column * side_m, left_m + (column + 1) * side_m),
                (bottom_m + row * side_m, bottom_m + (row + 1) * side_m),
                material=1,
            )
            for column, row in product(range(columns), range(rows))
            if (column + row) % 2 == 0
        ]
        turn = {name: getattr(config, name) for name in ("right_m", "up_m", "tilt_deg", "turn_deg")}
        world = tent_world(
            f"scene.chessboard {config.model_dump(exclude={'frames'})!r}",
            [turned(part, config.distance_m, **turn) for part in (paper, *squares)],
            [matte("paper", config.white), matte("black", config.black)],
            illumination_lux=illumination_lux,
        )
        return standing(world, config.frames)
