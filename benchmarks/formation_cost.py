"""What forming an image costs, over drawing it: processor time of each way, taken in turns in one process.

Over a pinhole's frame of the default renderer: motion with either shutter, the lens, both, the sensor; a
fisheye of 190 deg over the pinhole; and what others do: blur as the mean of 64 drawings, a fisheye fetched by
`cv2.remap` from six pictures.

Run: ``python benchmarks/formation_cost.py``
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import cv2
import numpy as np

from tacos_framework import Camera, Exposure, Lens, Rig
from tacos_framework.camera import agent_from_camera
from tacos_framework.formation import EpisodeDraws, ImageFormation, captured
from tacos_framework.formation.placed import PlacedSensor
from tacos_framework.testing.forming import placed
from tacos_plugins.effects.lens import Lens as LensEffect
from tacos_plugins.effects.motion import Motion
from tacos_plugins.renderers.moderngl.renderer import ModernglRenderer
from tacos_plugins.sensors.camera import CameraSensor
from tacos_worlds.indoor.scene import IndoorScene

SIZES_PX = ((1014, 760), (500, 380))
EXPOSURE = Exposure(time_s=0.008)
FRAMES = 8
DRAWS = EpisodeDraws(1, ("benchmark",))
SUBFRAMES = 64


def main() -> None:
    scene = IndoorScene(IndoorScene.Config(size_m=(8, 6), frames=FRAMES, motion="handheld"))
    episode = scene.episode(rng=np.random.default_rng(3), illumination_lux=50.0)
    renderer = ModernglRenderer(ModernglRenderer.Config())
    for width_px, height_px in SIZES_PX:
        print(f"{width_px} x {height_px} px")
        camera = Camera(
            "c", width_px, height_px, 3.0, width_px / 2.3 * 3e-3, agent_from_camera((0, 0, 0), -5)
        )
        seconds: dict[str, list[float]] = {}
        for i in range(FRAMES):
            for name, way in _ways(renderer, episode[i : i + 1], camera).items():
                start = time.process_time()
                way()
                seconds.setdefault(name, []).append(time.process_time() - start)
        middles = {name: float(np.median(found[1:])) for name, found in seconds.items()}
        frame_s = middles.pop("pinhole")
        print(f"  pinhole, drawn: {frame_s * 1e3:.0f} ms")
        for name, spent_s in middles.items():
            total_s = spent_s if name.startswith("fisheye") or "drawings" in name else frame_s + spent_s
            print(f"  {name}: x {total_s / frame_s:.2f}")


def _ways(renderer: Any, one: Any, camera: Camera) -> dict[str, Callable[[], Any]]:
    """What is timed; those that only change light begin with the same capture."""
    rig = Rig((camera,))
    draw = partial(renderer.capture, one, exposure=EXPOSURE)
    light = draw(rig=rig)
    rolling = replace(
        light, views=(replace(light.views[0], camera=replace(camera, shutter="rolling", row_time_us=15.0)),)
    )
    sensor = PlacedSensor("sensor.camera", "frames", CameraSensor(CameraSensor.Config()))

    def formed(capture: Any, *effects: Any) -> Any:
        return ImageFormation(EXPOSURE, [placed(effect) for effect in effects]).light(capture, DRAWS)

    half_field_rad = np.radians(95)
    fisheye = replace(
        camera,
        focal_length_mm=camera.width_px / 2 * camera.pixel_um * 1e-3 / half_field_rad,
        lens=Lens("equidistant", half_field_deg=95.0),
    )
    wide = captured(renderer, Rig((fisheye,)), draw)
    return {
        "pinhole": partial(draw, rig=rig),
        "motion, global shutter": partial(formed, light, Motion),
        "motion, rolling shutter": partial(formed, rolling, Motion),
        "lens": partial(formed, light, LensEffect),
        "lens and motion": partial(formed, light, LensEffect, Motion),
        "sensor": partial(ImageFormation(EXPOSURE).expose, light, sensor, DRAWS),
        "fisheye of 190 deg": partial(captured, renderer, Rig((fisheye,)), draw),
        "fisheye with its lens": partial(
            _both, partial(captured, renderer, Rig((fisheye,)), draw), partial(formed, wide, LensEffect)
        ),
        f"the mean of {SUBFRAMES} drawings": lambda: [draw(rig=rig) for _ in range(SUBFRAMES)],
        "fisheye by six pictures and cv2.remap": partial(_remapped, draw, fisheye),
    }


def _both(first: Callable[[], Any], second: Callable[[], Any]) -> None:
    first()
    second()


def _remapped(draw: Callable[..., Any], fisheye: Camera) -> None:
    side_px = round(1.5 * 2 * fisheye.focal_length_px)
    side = Camera("side", side_px, side_px, 1.0, side_px / 2 * 1e-3)
    places = np.random.default_rng(1).uniform(0, side_px - 1, (2, fisheye.height_px, fisheye.width_px))
    for _ in range(6):
        picture = draw(rig=Rig((side,))).views[0].luminance_cd_m2[0]
        cv2.remap(picture, *places.astype(np.float32), cv2.INTER_LINEAR)


if __name__ == "__main__":
    main()
