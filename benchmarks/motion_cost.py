"""What `effect.motion` costs, over a frame of the default renderer: processor time, taken in turns.

Run: ``python benchmarks/motion_cost.py``
"""

from __future__ import annotations

import time

import numpy as np

from tacos_framework import Camera, Exposure, Rig
from tacos_framework.camera import agent_from_camera
from tacos_framework.formation import EpisodeDraws, ImageFormation
from tacos_framework.testing.forming import placed
from tacos_plugins.effects.motion import Motion
from tacos_plugins.renderers.moderngl.renderer import ModernglRenderer
from tacos_worlds.indoor.scene import IndoorScene

SIZES_PX = ((1014, 760), (500, 380))
EXPOSURE = Exposure(time_s=0.008)
FRAMES = 8


def main() -> None:
    """Print the ratio for each size and shutter, and how far the image moves."""
    scene = IndoorScene(IndoorScene.Config(size_m=(8, 6), frames=FRAMES, motion="handheld"))
    episode = scene.episode(rng=np.random.default_rng(3), illumination_lux=50.0)
    renderer = ModernglRenderer(ModernglRenderer.Config())
    formation = ImageFormation(EXPOSURE, [placed(Motion)])
    for width_px, height_px in SIZES_PX:
        for shutter in ("global", "rolling"):
            focal_mm = width_px / 2.3 * 3e-3
            pose = agent_from_camera((0, 0, 0), -5)
            camera = Camera("c", width_px, height_px, 3.0, focal_mm, pose, shutter=shutter, row_time_us=15.0)
            drawn, moved = [], []
            rig = Rig((camera,))
            for i in range(FRAMES):
                one = episode[i : i + 1]
                start = time.process_time()
                capture = renderer.capture(one, rig=rig, exposure=EXPOSURE)
                middle = time.process_time()
                formation.light(capture, EpisodeDraws(1, ("benchmark",)))
                drawn.append(middle - start)
                moved.append(time.process_time() - middle)
            frame_s, motion_s = np.median(drawn), np.median(moved)
            size = f"{width_px} x {height_px} px, {shutter}"
            print(f"{size}: {frame_s * 1e3:.0f} ms, x {1 + motion_s / frame_s:.2f}")


if __name__ == "__main__":
    main()
