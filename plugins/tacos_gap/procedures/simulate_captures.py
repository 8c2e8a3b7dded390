"""A folder of captures from our own simulator, to rehearse a diagnosis without a camera."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from tacos_framework.plugins import Plugins
from tacos_framework.study.progress import Progress
from tacos_gap.bench import BenchSettings, CaptureBench
from tacos_gap.captures import RealCapture, write_captures


class SimulateCaptures:
    """Photographs the scenes of a measuring bench with a simulated camera, and writes them as captures.

    What is ``simulated`` comes from the renderer and the sensor without any effect; what is ``real`` are
    frames with the sensor's noise and the recipe's effects, so that a gap of known cause can be diagnosed.
    Writes ``captures.yaml`` and a folder of images for each capture.
    """

    class Config(BenchSettings):
        """Settings of the procedure."""

    def __init__(self, config: Config) -> None:
        self.config = config

    def run(self, *, out: Path, seed: int, plugins: Plugins, progress: Progress) -> Mapping[str, Any]:
        """Take all captures."""
        bench = CaptureBench(self.config, plugins, seed)
        progress.phase("Taking captures", len(bench.shots))
        taken: dict[str, int] = {}

        def announced() -> Iterator[RealCapture]:
            for capture in bench.captures():
                taken[capture.id] = capture.frames
                yield capture
                progress.step(capture.id)

        path = write_captures(out, announced())
        effects = ", ".join(use.use for use in self.config.effects) or "no effect"
        return {
            "captures": list(taken),
            "effects": [use.model_dump(mode="json") for use in self.config.effects],
            "summary": f"{len(taken)} captures, {sum(taken.values())} frames, {effects}: {path}",
        }
