"""Draws the picture of `docs/explanation/effects.md`: one frame of a room, once for each effect.

python benchmarks/effects_contact_sheet.py docs/explanation/images/effects.jpg
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_framework import Camera, Capture, Exposure, Plugins, Rig
from tacos_framework.camera import agent_from_camera, display_image
from tacos_framework.formation import EpisodeDraws, ImageFormation, PlacedEffect, PlacedSensor
from tacos_plugins.renderers.moderngl.renderer import ModernglRenderer
from tacos_plugins.sensors.affine_noise import AffineNoise
from tacos_worlds.indoor.scene import IndoorScene

WIDTH_PX, HEIGHT_PX = 200, 150
COLUMNS = 5
CAPTION_PX = 18
EXPOSURE = Exposure(time_s=0.030, f_number=2.0, gain_db=5.0)

SHOWN: Mapping[str, Mapping[str, Any]] = {
    "pose-error": {"rz": 4.0, "tx": 60.0},
    "illumination-gradient": {"gx": 1.2},
    "focal-length-error": {"scale": 1.25},
    "lens-distortion": {"k1": -0.25},
    "lateral-chromatic-aberration": {"red": 0.02, "blue": -0.02},
    "defocus": {"radius_px": 2.5},
    "lens-blur": {"sigma_px": 0.6, "growth": 4.0},
    "veiling-glare": {"share": 0.4},
    "vignetting": {"k1": -0.7},
    "rolling-shutter": {"row_time_us": 1000.0},
    "motion-blur": {"length_px": 9.0, "angle_deg": 20.0},
    "exposure-error": {"scale": 2.0},
    "flicker": {"depth": 0.4, "period_rows": 50.0},
    "auto-exposure": {"target_mlx_s": 4.0},
    "conversion-gain-error": {"scale": 30.0},
    "conversion-gain-mode": {"noise_scale": 10.0},
    "prnu": {"sigma": 0.15},
    "dsnu": {"column_sigma_dn": 6.0},
    "dark-current": {"rate_dn_s": 500.0, "hot_share": 0.01, "hot_rate_dn_s": 3000.0},
    "saturation": {"level_dn": 80.0},
    "crosstalk": {"share": 0.1},
    "nonlinearity": {"a2": -0.5},
    "read-noise": {"sigma_dn": 10.0},
    "row-noise": {"sigma_dn": 8.0},
    "black-level": {"offset_dn": 25.0},
    "quantisation": {"step_dn": 24.0},
    "lens-shading-correction": {"k1": 2.0},
    "white-balance": {"red": 1.6, "blue": 0.6},
    "colour-matrix": {"matrix": ((2.2, -1.0, -0.2), (-0.6, 2.2, -0.6), (0.0, -1.2, 2.2))},
    "demosaic": {"method": "bilinear"},
    "denoise": {"strength": 8.0},
    "sharpening": {"amount": 3.0},
    "tone-curve": {"gamma": 0.5},
    "jpeg": {"quality": 8},
}
"""Effects and settings far beyond those of a good camera, to be seen at this size."""


def main() -> None:
    """Write the picture."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("picture", type=Path)
    parser.add_argument("--seed", type=int, default=3)
    parser.add_argument("--frame", type=int, default=20)
    arguments = parser.parse_args()

    camera = Camera(
        "sheet", WIDTH_PX, HEIGHT_PX, pixel_um=3.0, focal_length_mm=0.5,
        agent_from_camera=agent_from_camera((0.0, 0.0, 0.0), pitch_deg=-8.0),
    )  # fmt: skip
    rig = Rig((camera,))
    scene = IndoorScene(IndoorScene.Config())
    episode = scene.episode(rng=np.random.default_rng(arguments.seed), illumination_lux=20.0)
    batch = episode[arguments.frame : arguments.frame + 1]
    capture = ModernglRenderer(ModernglRenderer.Config()).capture(batch, rig=rig, exposure=EXPOSURE)

    tiles = [captioned(picture_of(capture, None), "none")]
    tiles += [captioned(picture_of(capture, effect), effect.name) for effect in effects()]
    while len(tiles) % COLUMNS:
        tiles.append(np.full_like(tiles[0], 255))
    rows = [np.hstack(tiles[i : i + COLUMNS]) for i in range(0, len(tiles), COLUMNS)]
    cv2.imwrite(str(arguments.picture), np.vstack(rows)[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 80])


def effects() -> Iterator[PlacedEffect]:
    """The effects of the default plugins that are shown, with their settings."""
    plugins = Plugins.discover()
    for name, settings in SHOWN.items():
        cls = plugins.resolve(f"effect.{name}")
        yield PlacedEffect(f"effect.{name}", name, cls, cls.Config(**settings))


def picture_of(capture: Capture, effect: PlacedEffect | None) -> NDArray[np.uint8]:
    """The frame as people expect to see it, (H, W, 3)."""
    sensor = PlacedSensor("sensor.affine-noise", "frames", AffineNoise(AffineNoise.Config()))
    formation = ImageFormation(EXPOSURE, [effect] if effect else [])
    draws = EpisodeDraws(0, ("sheet",))
    frames = formation.expose(formation.light(capture, draws), sensor, draws)
    return display_image(frames.images[0][0], frames.black_level_dn, frames.white_level_dn)


def captioned(picture: NDArray[np.uint8], caption: str) -> NDArray[np.uint8]:
    """A picture with its name below and a white margin."""
    tile = np.full((HEIGHT_PX + CAPTION_PX + 4, WIDTH_PX + 4, 3), 255, np.uint8)
    tile[2 : HEIGHT_PX + 2, 2 : WIDTH_PX + 2] = picture
    baseline = (4, HEIGHT_PX + CAPTION_PX - 2)
    cv2.putText(tile, caption, baseline, cv2.FONT_HERSHEY_SIMPLEX, 0.38, (0, 0, 0), 1, cv2.LINE_AA)
    return tile


if __name__ == "__main__":
    main()
