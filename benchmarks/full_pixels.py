"""What a frame of twelve megapixels costs, part by part, in processor time of one core.

MALLOC_MMAP_MAX_=0 MALLOC_TRIM_THRESHOLD_=2147483648 OMP_NUM_THREADS=1 LP_NUM_THREADS=1 \
    python benchmarks/full_pixels.py --frames 4

The first two variables are those that `executor.process` sets for its workers.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from typing import TypeVar

import cv2
import numpy as np

from tacos_framework import Camera, Exposure, Rig, generator
from tacos_framework.camera import agent_from_camera
from tacos_framework.formation import EpisodeDraws, ImageFormation, PlacedSensor
from tacos_plugins.renderers.moderngl.renderer import ModernglRenderer
from tacos_plugins.sensors.affine_noise import AffineNoise
from tacos_plugins.sensors.gaussian import NormalNumbers
from tacos_plugins.tasks.faster_rcnn.labels import class_numbers, frame_labels
from tacos_plugins.tasks.orb_features import grey_image
from tacos_worlds.indoor.scene import IndoorScene

Result = TypeVar("Result")


class Stopwatch:
    """Processor time by name [s]."""

    def __init__(self) -> None:
        self.spent_s: dict[str, list[float]] = {}

    def of(self, name: str, work: Callable[[], Result]) -> Result:
        """Do something, and take its time."""
        began = time.process_time()
        done = work()
        self.spent_s.setdefault(name, []).append(time.process_time() - began)
        return done


def main() -> None:
    """Print the median processor time of each part."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--frames", type=int, default=4)
    parser.add_argument("--light-texel-m", type=float, default=0.08)
    arguments = parser.parse_args()

    watch = Stopwatch()
    scene = IndoorScene(IndoorScene.Config(frames=2 + arguments.frames))
    episode = watch.of(
        "world, once", lambda: scene.episode(rng=generator(7, "benchmark"), illumination_lux=20.0)
    )
    camera = Camera(
        "imx172",
        4000,
        3000,
        pixel_um=1.55,
        focal_length_mm=3.0,
        agent_from_camera=agent_from_camera((0, 0, 0), pitch_deg=-10.0),
    )
    rig, exposure = Rig((camera,)), Exposure(0.03, f_number=2.0, gain_db=5.0)
    renderer = ModernglRenderer(ModernglRenderer.Config(light_texel_m=arguments.light_texel_m))
    watch.of("light and first frame", lambda: renderer.capture(episode[:1], rig=rig, exposure=exposure))

    sensor = PlacedSensor("sensor.affine-noise", "frames", AffineNoise(AffineNoise.Config()), {})
    formation, draws = ImageFormation(exposure), EpisodeDraws(7, ("benchmark",))
    orb = cv2.ORB_create(nfeatures=2000, fastThreshold=7)
    classes = class_numbers(episode.world, episode.world.class_names[1:])
    normal = np.empty(camera.width_px * camera.height_px * 3, np.float32)
    for frame in range(1, len(episode)):
        batch = episode[frame : frame + 1]
        capture = watch.of("capture", lambda b=batch: renderer.capture(b, rig=rig, exposure=exposure))
        frames = watch.of("sensor", lambda c=capture: formation.expose(c, sensor, draws))
        image = frames.images[0][0]
        grey = watch.of("grey", lambda i=image: grey_image(i, 0.0, 255.0))
        watch.of("ORB", lambda g=grey: orb.detectAndCompute(g, None))
        rng = draws.rng(frame, "benchmark")
        watch.of("normal numbers (of the sensor)", lambda r=rng: NormalNumbers(r).fill(normal))
        watch.of(
            "labels",
            lambda c=capture: frame_labels(
                c.views[0].object_id[0], classes, minimum_area_px=100, minimum_share=0.001
            ),
        )
        watch.of(
            "normal numbers, by numpy",
            lambda r=rng: r.standard_normal(dtype=np.float32, out=normal),
        )
    for name, spent_s in watch.spent_s.items():
        print(f"{name:32} {np.median(spent_s):6.2f} s")


if __name__ == "__main__":
    main()
