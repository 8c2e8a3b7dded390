"""Where the processor time of a study goes, part by part: all of it in one process, with nothing kept.

Parts are functions of this repository, and a part's time is without that of the parts it calls. The clock is
that of the processor, so that other work on the machine matters little::

    OMP_NUM_THREADS=1 LP_NUM_THREADS=1 MALLOC_MMAP_MAX_=0 MALLOC_TRIM_THRESHOLD_=2147483648 \
        NUMBA_CACHE_DIR=$(mktemp -d) python benchmarks/study_split.py

The two variables in the middle are those `executor.process` sets for its workers; the last makes loops be
compiled, as in a fresh installation.
"""

from __future__ import annotations

import argparse
import functools
import os
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

RENDERER = "tacos_plugins.renderers.moderngl"
PARTS = {
    "colour by OpenGL: drawn and read": [
        f"{RENDERER}.targets:RenderTarget.read",
        f"{RENDERER}.painter:Painter.colour",
    ],
    "colour by loops": [f"{RENDERER}.painter:Painter.shade"],
    "half pixels: triangles, depth": [f"{RENDERER}.rendered_views:EdgeBlending._look"],
    "edges, ids, the rest of a capture": [f"{RENDERER}.renderer:ModernglRenderer.capture"],
    "sensor": ["tacos_framework.formation.image_formation:ImageFormation.expose"],
    "ORB": ["tacos_plugins.tasks.orb_features:OrbScorer.update"],
    "obstacles": ["tacos_plugins.tasks.obstacle_visibility:ObstacleScorer.update"],
    "worlds: built": ["tacos_worlds.indoor.scene:IndoorScene.episode"],
    "worlds: indirect light": ["tacos_worlds.indoor.assembly:with_illuminance"],
    "worlds: direct light baked": [f"{RENDERER}.device:light_world"],
    "worlds: tables to shade by, or uploaded": [
        f"{RENDERER}.drawn_world:GpuWorld",
        f"{RENDERER}.drawn_world:ShadingTables",
    ],
    "worlds: surroundings of glossy things": [
        f"{RENDERER}.device:Device._look_around",
        f"{RENDERER}.drawn_world:DrawnWorld.mirror",
    ],
    "worlds: kept on disk": [
        "tacos_plugins.kept_worlds.store:WorldStore._write",
        "tacos_plugins.kept_worlds.store:WorldStore._read",
    ],
    "loops compiled": ["numba.core.dispatcher:_FunctionCompiler.compile"],
    "optimizer": [
        f"tacos_framework.study.guarded_optimizer:GuardedOptimizer.{verb}" for verb in ("ask", "tell", "stop")
    ],
    "analysis of the study": ["tacos_framework.study.study:Study._analyse"],
    "result, report": [
        "tacos_framework.study.study:Study.finish",
        "tacos_framework.study.running:_report",
    ],
}
"""Functions by the part they are."""


class Split:
    """Processor time by part [s]; a part inside another is taken out of it."""

    def __init__(self) -> None:
        self.spent_s = Counter[str]()
        self.calls = Counter[str]()
        self._open = ["imports, graph, the rest"]
        self._since = time.process_time()

    def switch(self) -> None:
        """Give the time since the last switch to the part that is open."""
        now = time.process_time()
        self.spent_s[self._open[-1]] += now - self._since  # type: ignore[assignment]
        self._since = now

    def of(self, part: str, function: Callable[..., Any]) -> Callable[..., Any]:
        """The function, its time counted for a part."""

        @functools.wraps(function, updated=())
        def counted(*args: Any, **kwargs: Any) -> Any:
            self.switch()
            self._open.append(part)
            self.calls[part] += 1
            try:
                return function(*args, **kwargs)
            finally:
                self.switch()
                self._open.pop()

        return counted


def count(split: Split) -> None:
    """Have all functions of `PARTS` counted."""
    for part, places in PARTS.items():
        for place in places:
            module, _, path = place.partition(":")
            *within, name = path.split(".")
            owner = functools.reduce(getattr, within, import_module(module))
            setattr(owner, name, split.of(part, getattr(owner, name)))


def main() -> None:
    """Run and print."""
    split = Split()
    from tacos_framework import load_recipe, run  # counted as imports

    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--recipe", default="headset_quick")
    parser.add_argument("--evaluations", type=int, help="candidates of the search; the recipe's by default")
    arguments = parser.parse_args()
    sets: dict[str, Any] = {"executor": {"use": "executor.local"}}
    if arguments.evaluations:
        sets["optimizer.evaluations"] = arguments.evaluations
    recipe = load_recipe(arguments.recipe, sets)
    count(split)
    with tempfile.TemporaryDirectory() as folder:
        os.environ["TACOS_CACHE"] = str(Path(folder) / "cache")
        run(recipe, out=Path(folder) / "out")
        split.switch()
    total_s = sum(split.spent_s.values())
    for part, seconds in sorted(split.spent_s.items(), key=lambda each: -each[1]):
        print(f"{part:<40}{seconds:>8.1f} s {seconds / total_s:>6.1%} {split.calls[part]:>7} calls")
    print(f"{'all':<40}{total_s:>8.1f} s, {split.calls['sensor']} images")


if __name__ == "__main__":
    main()
