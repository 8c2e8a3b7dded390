"""Whether memory stays flat over a long study: 2,000 candidates through the real renderer, at small size.

Generations see new worlds, so that worlds are built, put on the device and let go of all the time::

    LP_NUM_THREADS=1 OMP_NUM_THREADS=1 nice python benchmarks/soak.py --candidates 2000

Prints the memory of this process (which renders) as the study goes on, and the growth over its second half.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

import numpy as np

from tacos_framework import run
from tacos_framework.recipe import Recipe
from tacos_framework.simulation import Evaluation

REPORT_EVERY = 100
"""Candidates between two lines."""


def recipe(candidates: int, generation: int, frames: int) -> Recipe:
    """A small study of the headset's kind by random search."""
    return Recipe.model_validate(
        {
            "name": "soak",
            "seed": 7,
            "rig": {"use": "rig.monocular", "binning": 24},
            "design": {
                "pitch_deg": {"between": [-30, 30]},
                "focal_length_mm": {"between": [2, 8]},
                "sensor": {"from": "image_sensors"},
            },
            "nodes": {
                "world": {"use": "scene.indoor", "frames": frames, "size_m": [11, 6]},
                "capture": {"use": "renderer.moderngl", "in": {"episode": "world"}, "light_texel_m": 0.3},
                "frames": {"use": "sensor.affine-noise", "in": {"capture": "capture"}},
                "features": {"use": "task.orb-features", "in": {"frames": "frames"}},
            },
            "fitness": [{"score": "features.inlier_ratio", "weight": 1}],
            "optimizer": {"use": "optimizer.random", "evaluations": candidates, "batch": generation},
        }
    )


class MemoryWatch:
    """Notes the memory of this process while candidates go by; a `Progress`."""

    def __init__(self) -> None:
        self.candidates: list[int] = []
        self.resident_mib: list[float] = []
        self._count = 0
        self._began = time.monotonic()

    def phase(self, title: str, candidates: int | None) -> None:
        """Nothing to note."""

    def best(self, best: Evaluation | None) -> None:
        """Nothing to note."""

    def evaluated(self, evaluation: Evaluation) -> None:
        """Note the memory, now and then print it."""
        self._count += 1
        self.candidates.append(self._count)
        self.resident_mib.append(resident_mib())
        if self._count % REPORT_EVERY == 0:
            seconds = time.monotonic() - self._began
            print(
                f"{self._count:>6} candidates {self.resident_mib[-1]:>7.1f} MiB {seconds:>7.0f} s", flush=True
            )


def resident_mib() -> float:
    """Memory this process holds [MiB]."""
    for line in Path("/proc/self/status").read_text("ascii").splitlines():
        if line.startswith("VmRSS:"):
            return int(line.split()[1]) / 1024
    raise OSError("/proc/self/status does not tell the memory")


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--candidates", type=int, default=2000)
    parser.add_argument("--generation", type=int, default=40)
    parser.add_argument("--frames", type=int, default=4)
    arguments = parser.parse_args()
    watch = MemoryWatch()
    with tempfile.TemporaryDirectory() as folder:
        result = run(
            recipe(arguments.candidates, arguments.generation, arguments.frames),
            out=Path(folder) / "out",
            progress=watch,
            report=False,
        )
    half = len(watch.candidates) // 2
    slope, _ = np.polyfit(watch.candidates[half:], watch.resident_mib[half:], 1)
    print(f"images              {result['frames_rendered']}")
    print(f"seconds             {result['seconds']:.0f}")
    print(f"largest             {max(watch.resident_mib):.0f} MiB")
    print(f"growth, second half {slope * 1000:.1f} MiB per 1000 candidates (straight-line fit)")


if __name__ == "__main__":
    main()
