"""Frames that stream through the graph one by one, against batches of them: processor time and memory.

The same study's frames, in the same run, each way in a process of its own, the two in turn::

    LP_NUM_THREADS=1 OMP_NUM_THREADS=1 python benchmarks/frames_one_by_one.py --rounds 3

`Task.frames_per_update` is what a task that wants several frames at a time asks for; here a task that takes
its frames and looks at none of them asks for 1 or for ``--batch``.
"""

from __future__ import annotations

import argparse
import json
import resource
import statistics
import subprocess
import sys
import time
from typing import ClassVar

from tacos_framework import Component, FrameBatch, Plugins, Recipe, Scores, Settings, State, hookimpl
from tacos_framework.plan import make_plan
from tacos_framework.simulation import EpisodeSpec, ScoreJob, Simulation

SENSOR = {"width_px": 4056, "height_px": 3040, "pixel_um": 1.55}
VALUES = {"focal_length_mm": 3.6, "pitch_deg": -10.0}


class MeanValue:
    """Scores the mean value of the frames."""

    def __init__(self) -> None:
        self._means: list[float] = []

    def update(self, frames: FrameBatch) -> None:
        """Take in frames."""
        self._means += [float(image.mean()) for image in frames.images[0]]

    def scores(self) -> Scores:
        """The mean."""
        return {"mean_dn": sum(self._means) / len(self._means)}


class Brightness:
    """A task that asks for as many frames at a time as the benchmark says."""

    class Config(Settings):
        """No settings."""

    scores: ClassVar[tuple[str, ...]] = ("mean_dn",)
    frames_per_update: ClassVar[int] = 1

    def __init__(self, config: Config) -> None:
        pass

    def begin(self, *, state: State | None) -> MeanValue:
        """A scorer."""
        return MeanValue()


@hookimpl
def tacos_components() -> list[Component]:
    """The task above."""
    return [Component("task", "brightness", f"{__name__}:Brightness", summary="Mean value.")]


def recipe(frames: int) -> Recipe:
    """A camera of 1014 x 760 pixels in a furnished room."""
    return Recipe.model_validate(
        {
            "name": "frames",
            "rig": {"use": "rig.monocular", "binning": 4, "sensor": SENSOR},
            "design": {"focal_length_mm": {"between": [2, 8]}, "pitch_deg": {"between": [-30, 30]}},
            "nodes": {
                "world": {"use": "scene.indoor", "frames": frames, "size_m": [11, 6]},
                "capture": {"use": "renderer.moderngl", "in": {"episode": "world"}, "light_texel_m": 0.3},
                "frames": {"use": "sensor.affine-noise", "in": {"capture": "capture"}},
                "light": {"use": "task.brightness", "in": {"frames": "frames"}},
            },
            "fitness": [{"score": "light.mean_dn", "weight": 1}],
            "optimizer": {"use": "optimizer.random", "evaluations": 1, "batch": 1},
        }
    )


def measure(batch: int, frames: int) -> dict[str, float]:
    """Processor seconds per frame, and the most memory, of one way."""
    Brightness.frames_per_update = batch
    plugins = Plugins.discover()
    plugins.register(sys.modules[__name__])
    simulation = Simulation(make_plan(recipe(frames), plugins))
    warm, timed = (ScoreJob(VALUES, (EpisodeSpec(7, ("design", 0), frames),)) for _ in range(2))
    warm.run(simulation)
    began = time.process_time()
    evaluation = timed.run(simulation)
    spent = time.process_time() - began
    assert evaluation.fitness is not None, evaluation.failed
    return {
        "ms": 1e3 * spent / evaluation.images,
        "mib": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
        "fitness": evaluation.fitness,
    }


def main() -> None:
    """Measure both ways in turn and print the medians and their ratios."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--frames", type=int, default=64, help="frames of the episode")
    parser.add_argument("--batch", type=int, default=32, help="frames of the larger batches")
    parser.add_argument("--rounds", type=int, default=3, help="processes each way")
    parser.add_argument("--only", type=int, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.only:
        print(json.dumps(measure(arguments.only, arguments.frames)))
        return
    found: dict[int, list[dict[str, float]]] = {1: [], arguments.batch: []}
    for _ in range(arguments.rounds):
        for batch, results in found.items():
            command = [sys.executable, __file__, f"--only={batch}", f"--frames={arguments.frames}"]
            done = subprocess.run(command, check=True, capture_output=True, text=True)
            results.append(json.loads(done.stdout.splitlines()[-1]))
    assert len({r["fitness"] for results in found.values() for r in results}) == 1, "results differ"
    median = {
        batch: {key: statistics.median(r[key] for r in results) for key in ("ms", "mib")}
        for batch, results in found.items()
    }
    for batch, figures in median.items():
        print(f"by {batch:>3}: {figures['ms']:6.1f} ms of CPU a frame, {figures['mib']:6.0f} MiB at most")
    one, many = median[1], median[arguments.batch]
    saved = {key: 1 - one[key] / many[key] for key in one}
    print(f"one by one: {saved['ms']:.0%} less CPU, {saved['mib']:.0%} less memory")


if __name__ == "__main__":
    main()
