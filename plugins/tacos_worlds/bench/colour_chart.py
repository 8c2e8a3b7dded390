"""The scene `scene.colour-chart`: the 24 patches of a ColorChecker."""

from __future__ import annotations

from functools import cache

import numpy as np

from tacos_framework import Episode, Material, Object, Settings, setting
from tacos_worlds.bench.stand import facing, matte, standing, tent_world

CHART = "ColorChecker24 - After November 2014"
"""The data set of colour-science; X-Rite's reference values under D50."""

COLUMNS, ROWS = 6, 4
IN_FRONT_M = 1e-4
"""How far the patches lie before the frame [m]."""


class ColourChart:
    """A ColorChecker of 24 matte patches in a dark frame, each patch an object of the class ``patch``.

    Reflectances per linear sRGB channel follow from X-Rite's reference values, adapted from D50 to the white
    point of sRGB (Bradford). The cyan patch lies outside of sRGB; its red is 0.

    Source: colour-science, ``CCS_COLOURCHECKERS``.
    """

    class Config(Settings):
        patch_m: float = setting(0.028, help="Side of a patch.", unit="m", gt=0)
        gap_m: float = setting(0.005, help="Dark space between patches.", unit="m", gt=0)
        frame: float = setting(0.03, help="Reflectance of the dark frame.", ge=0, le=1)
        distance_m: float = setting(0.5, help="From the camera to the chart.", unit="m", gt=0)
        frames: int = setting(1, help="Frames taken.", ge=1, le=1_000_000)

    def __init__(self, config: Config) -> None:
        self.config = config

    def episode(self, *, illumination_lux: float) -> Episode:
        config = self.config
        step_m = config.patch_m + config.gap_m
        half_width_m, half_height_m = COLUMNS * step_m / 2, ROWS * step_m / 2
        border_m = config.gap_m
        frame = facing(
            config.distance_m,
            (-half_width_m - border_m, half_width_m + border_m),
            (-half_height_m - border_m, half_height_m + border_m),
        )
        materials, patches = [matte("frame", config.frame)], []
        for i, (name, reflectance) in enumerate(reflectances().items()):
            row, column = divmod(i, COLUMNS)
            left_m = -half_width_m + column * step_m + config.gap_m / 2
            top_m = half_height_m - row * step_m - config.gap_m / 2
            materials.append(Material(name, np.array(reflectance, np.float32), roughness=1.0))
            patches.append(
                facing(
                    config.distance_m - IN_FRONT_M,
                    (left_m, left_m + config.patch_m),
                    (top_m - config.patch_m, top_m),
                    material=i + 1,
                    object_id=i + 2,
                )
            )
        world = tent_world(
            f"scene.colour-chart {config.model_dump(exclude={'frames'})!r}",
            [frame, *patches],
            materials,
            illumination_lux=illumination_lux,
            objects=(Object("frame", "frame"), *(Object(name, "patch") for name in reflectances())),
        )
        return standing(world, config.frames)


@cache
def reflectances() -> dict[str, tuple[float, float, float]]:
    """For each patch, from the top left row by row, its reflectance per linear sRGB channel [1]."""
    import colour

    chart = colour.CCS_COLOURCHECKERS[CHART]
    found = {}
    for name, xyy in chart.data.items():
        rgb = colour.XYZ_to_RGB(
            colour.xyY_to_XYZ(xyy), "sRGB", chart.illuminant, chromatic_adaptation_transform="Bradford"
        )
        red, green, blue = np.clip(rgb, 0, 1).tolist()
        found[str(name)] = (red, green, blue)
    return found
