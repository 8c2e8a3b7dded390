"""Draws the picture of `docs/explanation/worlds.md`: rooms and streets, by day and by night.

OMP_NUM_THREADS=1 python benchmarks/scenes_contact_sheet.py docs/explanation/images/worlds.jpg

Also prints, for each world, its triangles, the CPU time to build it, to light it for the renderer, and for a
frame of 640 x 480 pixels.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_framework import Camera, Episode, Exposure, Rig
from tacos_framework.camera import agent_from_camera
from tacos_plugins.renderers.moderngl.renderer import ModernglRenderer
from tacos_view.pictures import contact_sheet
from tacos_worlds.indoor.scene import IndoorScene
from tacos_worlds.street.scene import StreetScene

SIZE_PX = (640, 480)
TILE_PX = (400, 300)
COLUMNS = 3
FIELD_DEG = 75.0
LOOKED_AT = 12
"""Frames of each world that are looked at; those with most things in sight are shown."""
APART = 2
"""Frames that are shown lie so many of these apart."""


@dataclass(frozen=True)
class Place:
    """A world and how many pictures of it are shown."""

    scene: type[IndoorScene] | type[StreetScene]
    seed: int
    lux: float
    pictures: int
    settings: Mapping[str, Any] = field(default_factory=dict)


ROOMS: Mapping[str, Any] = {"frames": 48, "frame_rate_hz": 1.0, "people": 0.8, "clutter": 0.8}
DRIVE: Mapping[str, Any] = {"blocks": 1, "frames": 12, "frame_rate_hz": 1.0}
PLACES = (
    Place(IndoorScene, 3, 200.0, 3, ROOMS),
    Place(StreetScene, 1, 20_000.0, 3, DRIVE),
    Place(StreetScene, 3, 10.0, 3, {**DRIVE, "light": "night"}),
)


def main() -> None:
    """Render the sheet and write it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("output", type=Path, help="Picture to write.")
    output = parser.parse_args().output
    tiles = [tile for place in PLACES for tile in pictures(place)]
    sheet = contact_sheet(tiles, COLUMNS, widest_px=COLUMNS * TILE_PX[0] + 40)
    cv2.imwrite(str(output), sheet[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 84])


def pictures(place: Place) -> list[NDArray[np.uint8]]:
    """The frames of a world in which most things are in sight, in the order of the way."""
    scene = place.scene(place.scene.Config.model_validate(dict(place.settings)))
    began_s = time.process_time()
    episode = scene.episode(rng=np.random.default_rng(place.seed), illumination_lux=place.lux)
    built_s = time.process_time()
    renderer = ModernglRenderer(ModernglRenderer.Config(near_m=0.1))
    looked_at = np.linspace(0, len(episode) - 1, LOOKED_AT).astype(int).tolist()
    frames = [luminance(renderer, episode, looked_at[0])]
    lit_s = time.process_time()
    frames += [luminance(renderer, episode, at) for at in looked_at[1:]]
    per_frame_ms = (time.process_time() - lit_s) / (LOOKED_AT - 1) * 1e3
    light = dict(place.settings).get("light", "")
    print(
        f"{place.scene.__name__} {light}: {episode.world.triangle_count} triangles, "
        f"built in {built_s - began_s:.1f} s, lit in {lit_s - built_s:.1f} s, {per_frame_ms:.0f} ms a frame"
    )
    chosen: list[int] = []
    for at in sorted(range(LOOKED_AT), key=lambda k: -frames[k][1]):
        if len(chosen) < place.pictures and all(abs(at - other) >= APART for other in chosen):
            chosen.append(at)
    return [shown(frames[at][0]) for at in sorted(chosen)]


def luminance(renderer: ModernglRenderer, episode: Episode, at: int) -> tuple[NDArray[np.float32], int]:
    """(H, W, 3) luminance of a frame [cd/m2], and how many things of some size are in sight."""
    width_px, height_px = SIZE_PX
    focal_px = width_px / 2 / math.tan(math.radians(FIELD_DEG / 2))
    pose = agent_from_camera((0.0, 0.0, 0.0), -6.0)
    camera = Camera("sheet", width_px, height_px, 1.0, focal_px * 1e-3, agent_from_camera=pose)
    (view,) = renderer.capture(episode[at : at + 1], rig=Rig((camera,)), exposure=Exposure()).views
    assert view.object_id is not None
    _, pixels = np.unique(view.object_id[0], return_counts=True)
    return view.luminance_cd_m2[0], int((pixels > 150).sum())


def shown(luminance_cd_m2: NDArray[np.float32]) -> NDArray[np.uint8]:
    """A tile: exposed for its bright parts, highlights rolled off (Reinhard et al. 2002, eq. 4), in sRGB."""
    bright = float(np.percentile(luminance_cd_m2.mean(axis=-1), 80))
    scaled = luminance_cd_m2.astype(np.float64) / max(bright, 1e-9) * 0.55
    rolled = np.clip(scaled * (1 + scaled / 9) / (1 + scaled), 0, 1)
    encoded = (rolled ** (1 / 2.2) * 255).astype(np.uint8)
    return np.asarray(cv2.resize(encoded, TILE_PX, interpolation=cv2.INTER_AREA), np.uint8)


if __name__ == "__main__":
    main()
