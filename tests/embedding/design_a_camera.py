"""A host that designs a camera: its own task, its own workers, its own words for what goes on."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, ClassVar, TypeVar

import numpy as np

import tacos_framework as tacos

Job = TypeVar("Job")
Result = TypeVar("Result")


class Contrast:
    """Scores how much the brightness of the frames varies within each of them."""

    class Config(tacos.Settings):
        darkest_dn: float = tacos.setting(
            1.0, help="Frames darker than this have no contrast.", unit="DN", gt=0
        )

    scores: ClassVar[tuple[str, ...]] = ("contrast",)

    def __init__(self, config: Config) -> None:
        self.config = config

    def begin(self, *, state: tacos.State | None) -> ContrastScorer:
        """A scorer for one episode."""
        return ContrastScorer(self.config.darkest_dn)


class ContrastScorer:
    """Takes in the frames of one episode, batch by batch."""

    def __init__(self, darkest_dn: float) -> None:
        self._darkest_dn = darkest_dn
        self._found: list[float] = []

    def update(self, frames: tacos.FrameBatch) -> None:
        for image in frames.images[0]:
            mean_dn = float(image.mean())
            self._found.append(float(image.std()) / max(mean_dn, self._darkest_dn))

    def scores(self) -> tacos.Scores:
        """Mean of the frames' root-mean-square contrasts."""
        return {"contrast": float(np.mean(self._found))}


class HostPlugin:
    """What the host brings: a component, and somebody who listens."""

    @tacos.hookimpl
    def tacos_components(self) -> list[tacos.Component]:
        """The host's own components."""
        return [
            tacos.Component("task", "contrast", f"{__name__}:Contrast", summary="Contrast of the frames.")
        ]

    @tacos.hookimpl
    def tacos_candidate_failed(self, candidate: dict[str, Any], reason: str) -> None:
        """Tell of a candidate that could not be evaluated."""
        print(f"failed: {candidate}: {reason}")


class Lines:
    """Progress in lines of text."""

    def phase(self, title: str, candidates: int | None) -> None:
        """A part begins."""
        print(f"{title}: {candidates} candidates")

    def evaluated(self, evaluation: tacos.Evaluation) -> None:
        """One candidate was evaluated."""

    def best(self, best: tacos.Evaluation | None) -> None:
        """A generation ended."""
        print(f"best so far: {best.fitness:.3f}" if best and best.fitness is not None else "none yet")

    def step(self, note: str = "") -> None:
        """One step of a procedure is done."""


class OneThread:
    """Evaluates in a thread of the host; a pool of processes or a cluster's client has the same shape."""

    def __init__(self) -> None:
        self._pool = ThreadPoolExecutor(1)

    def map(self, evaluate: Callable[[Job], Result], jobs: Sequence[Job]) -> Iterator[Result]:
        return self._pool.map(evaluate, jobs)

    def close(self) -> None:
        """Wait for what is being evaluated."""
        self._pool.shutdown()


def recipe() -> tacos.Recipe:
    """What to design; the same as a file of YAML could say."""
    return tacos.Recipe.model_validate(
        {
            "name": "contrast",
            "rig": {
                "use": "rig.monocular",
                "sensor": {"name": "tiny", "width_px": 32, "height_px": 24, "pixel_um": 60},
            },
            "design": {"focal_length_mm": {"between": [1, 4]}, "pitch_deg": {"between": [-30, 30]}},
            "nodes": {
                "world": {"use": "scene.indoor", "frames": 2, "size_m": [11, 6]},
                "capture": {"use": "renderer.analytic", "in": {"episode": "world"}},
                "frames": {"use": "sensor.affine-noise", "in": {"capture": "capture"}},
                "contrast": {"use": "task.contrast", "in": {"frames": "frames"}},
            },
            "fitness": [{"score": "contrast.contrast", "weight": 1}],
            "optimizer": {"use": "optimizer.random", "evaluations": 4, "batch": 2},
        }
    )


def main(out: str | Path) -> int:
    """Design the camera; leave the results in a folder."""
    plugins = tacos.Plugins.discover()
    plugins.register(HostPlugin())
    executor = OneThread()
    try:
        result = tacos.run(
            recipe(), out=out, plugins=plugins, executor=executor, progress=Lines(), report=False
        )
    except tacos.UserError as error:
        for fault in error.faults:
            print(fault.where, fault.what, fault.remedy, file=sys.stderr)
        return 2
    finally:
        executor.close()
    camera = result["best"]["camera"]
    print(f"{camera['focal_length_mm']:.2f} mm, tilted by {camera['pitch_deg']:.0f} deg")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
