"""The scene `scene.colour-chart`: the 24 patches of a ColorChecker."""

from __future__ import annotations

import numpy as np

from tacos_framework import Episode, Material, Object, Settings, setting
from tacos_worlds.bench.stand import facing, matte, standing, tent_world

REFLECTANCES: dict[str, tuple[float, float, float]] = {
    "dark skin": (0.173683438, 0.0787931455, 0.0528558272),
    "light skin": (0.559783642, 0.277447244, 0.210891601),
    "blue sky": (0.104201148, 0.188915205, 0.328930128),
    "foliage": (0.10574358, 0.15075416, 0.0508371382),
    "blue flower": (0.227438602, 0.212408085, 0.426446443),
    "bluish green": (0.115292581, 0.507441402, 0.411128538),
    "orange": (0.745902586, 0.202142982, 0.0298681531),
    "purplish blue": (0.0587418358, 0.101181674, 0.387748024),
    "moderate red": (0.560130133, 0.0801532278, 0.114586052),
    "purple": (0.10916728, 0.0420004715, 0.138137219),
    "yellow green": (0.332750316, 0.49738559, 0.0425962376),
    "orange yellow": (0.771036729, 0.35791839, 0.020449107),
    "blue": (0.0209555102, 0.0475336483, 0.284129106),
    "green": (0.0460622305, 0.292047987, 0.0614785886),
    "red": (0.44617064, 0.036405825, 0.040551078),
    "yellow": (0.841684297, 0.574407555, 0.00466223049),
    "magenta": (0.522341575, 0.0778168997, 0.289313068),
    "cyan": (0.0, 0.233661642, 0.377189573),
    "white 9.5 (.05 D)": (0.879528644, 0.885027874, 0.834247248),
    "neutral 8 (.23 D)": (0.584493461, 0.592168424, 0.584478351),
    "neutral 6.5 (.44 D)": (0.357693563, 0.367077156, 0.36526625),
    "neutral 5 (.70 D)": (0.190093915, 0.190866263, 0.189813508),
    "neutral 3.5 (1.05 D)": (0.0859293637, 0.0887353175, 0.0898039841),
    "black 2 (1.5 D)": (0.0313542421, 0.0314958633, 0.0323225813),
}
"""For each patch, from the top left row by row, its reflectance per linear sRGB channel [1].

X-Rite's reference values under D50 (from November 2014 on), adapted to the white point of sRGB (Bradford); a
test computes them anew by colour-science.
"""

COLUMNS, ROWS = 6, 4
IN_FRONT_M = 1e-4
"""How far the patches lie before the frame [m]."""


class ColourChart:
    """A ColorChecker of 24 matte patches in a dark frame, each patch an object of the class ``patch``.

    The cyan patch lies outside of sRGB; its red is 0.
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
        for i, (name, reflectance) in enumerate(REFLECTANCES.items()):
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
            objects=(Object("frame", "frame"), *(Object(name, "patch") for name in REFLECTANCES)),
        )
        return standing(world, config.frames)
