"""Processor time of a house as `headset_quick` has them: built with its indirect light, and lit and uploaded.

Nothing is kept. To set two versions side by side run it in turns with the PYTHONPATH of each::

    OMP_NUM_THREADS=1 LP_NUM_THREADS=1 MALLOC_MMAP_MAX_=0 MALLOC_TRIM_THRESHOLD_=2147483648 \
        python benchmarks/houses_built.py --houses 6

The two variables at the end are those `executor.process` sets for its workers.
"""

from __future__ import annotations

import argparse
import os
import tempfile
import time

import numpy as np
from renderers.tour import benchmark_camera

from tacos_framework import Exposure, Rig
from tacos_plugins.renderers.moderngl.renderer import ModernglRenderer
from tacos_worlds.indoor.scene import IndoorScene

HOUSE = IndoorScene.Config(
    size_m=(10, 6),
    sampling="approaches",
    frames=16,
    before_step_s=(3.2, 3.0, 1.2, 1.0),
    camera_height_m=(1, 2),
)
RENDERER = ModernglRenderer.Config(light_texel_m=0.12)


def built_and_lit_s(seed: int) -> tuple[float, float]:
    """What building a house takes, and lighting it with a first picture of 640 x 480 [s]."""
    began_s = time.process_time()
    episode = IndoorScene(HOUSE).episode(rng=np.random.default_rng(seed), illumination_lux=20.0)
    built_s = time.process_time()
    rig = Rig((benchmark_camera(640, 480),))
    ModernglRenderer(RENDERER).capture(episode[:1], rig=rig, exposure=Exposure())
    return built_s - began_s, time.process_time() - built_s


def main() -> None:
    """Print means and least."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--houses", type=int, default=6, help="how many, after one that compiles loops")
    houses = parser.parse_args().houses
    with tempfile.TemporaryDirectory() as folder:
        os.environ["TACOS_CACHE"] = folder
        built_and_lit_s(0)
        times_s = np.array([built_and_lit_s(seed) for seed in range(1, houses + 1)])
    for name, column in zip(
        ("built, indirect light included", "lit, uploaded, one picture"), times_s.T, strict=True
    ):
        print(f"{name:32} {column.mean():.2f} s a house, the least {column.min():.2f} s")


if __name__ == "__main__":
    main()
