"""A folder of captures from our own simulator, to rehearse a diagnosis without a camera."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from tacos_framework import Plugins, Progress
from tacos_framework.store import Results
from tacos_gap.captures import CaptureWriter, WrittenCapture
from tacos_gap.captures.missing import BEGUN
from tacos_gap.simulation.bench import BenchSettings, CaptureBench


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

    def run(
        self, *, out: Path, seed: int, plugins: Plugins, progress: Progress, resume: bool
    ) -> Mapping[str, Any]:
        """Take all captures, or those that a broken run has not taken: each depends on seed and id alone."""
        bench = CaptureBench(self.config, plugins, seed)
        results = Results(out)
        kept = [WrittenCapture(**line) for line in results.read_lines(BEGUN)] if resume else []
        writer = CaptureWriter(out, kept)
        done = {entry["id"] for entry in writer.entries}
        progress.phase("Taking captures", len(bench.shots))
        for shot in bench.shots.values():
            if shot.id not in done:
                results.append_line(BEGUN, asdict(writer.add(bench.capture(shot))))
            progress.step(shot.id)
        path = writer.close()
        results.remove(BEGUN)
        frames = sum(len(entry["real"]) for entry in writer.entries)
        effects = ", ".join(use.use for use in self.config.effects) or "no effect"
        return {
            "captures": [entry["id"] for entry in writer.entries],
            "effects": [use.model_dump(mode="json") for use in self.config.effects],
            "summary": f"{len(writer.entries)} captures, {frames} frames, {effects}: {path}",
        }
