"""What racing saves: the quick headset study, with longer walks, with and without a race, on the same seeds.

Prints images, seconds and the design's fitness on the test scenes, run by run and on average::

    OMP_NUM_THREADS=1 nice python benchmarks/racing.py --seeds 2

Walks of the quick study's 32 frames pass a threshold once, which leaves a race nothing to compare; 160 frames
pass several.
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tacos_framework import run
from tacos_framework.recipe import Recipe
from tacos_framework.recipe.loading import read_any_recipe

QUICK = Path(__file__).parents[1] / "recipes" / "headset_quick.yaml"
FRAMES = 160
BLOCKS = 20
TEST_FRAMES = 160
SETS: Mapping[str, Any] = {
    "study.blocks": BLOCKS,
    "nodes.world.frames": FRAMES,
    "test.frames": TEST_FRAMES,
}
RACE: Mapping[str, Any] = {"standard_errors": 2.0, "min_blocks": 3}


def recipe(seed: int, race: Mapping[str, Any] | None, sets: Mapping[str, Any]) -> Recipe:
    """The quick study with longer walks, cut into blocks, without cameras off the shelf."""
    read, faults = read_any_recipe(QUICK, sets={"seed": seed, **SETS, **sets})
    assert not faults, faults
    study = {**read.study.model_dump(), "race": race}
    return Recipe.model_validate({**read.as_data(), "compare": None, "study": study})


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--binning", type=float, default=4)
    parser.add_argument("--workers", type=int, default=1)
    arguments = parser.parse_args()
    sets = {"rig.binning": arguments.binning, "executor.workers": arguments.workers}
    print(f"{'seed':>4} {'race':>5} {'images':>7} {'seconds':>8} {'fitness on test scenes':>23}")
    found: dict[bool, list[dict[str, Any]]] = {False: [], True: []}
    for seed in range(1, arguments.seeds + 1):
        for race in (None, RACE):
            with tempfile.TemporaryDirectory() as folder:
                result = run(recipe(seed, race, sets), out=Path(folder) / "out", report=False)
            tested = result["test"]["designed"]
            searched = result["frames_rendered"] - 3 * TEST_FRAMES  # without the test
            row = {"images": searched, "seconds": result["seconds"], "fitness": tested["fitness"]}
            found[race is not None].append(row)
            print(
                f"{seed:>4} {'yes' if race else 'no':>5} {searched:>7} {result['seconds']:>8.0f} "
                f"{tested['fitness']:>23.3f}",
                flush=True,
            )
    for race, rows in found.items():
        means = {key: statistics.mean(row[key] for row in rows) for key in rows[0]}
        print(
            f"mean {'yes' if race else 'no':>5} {means['images']:>7.0f} {means['seconds']:>8.0f} "
            f"{means['fitness']:>23.3f}"
        )


if __name__ == "__main__":
    main()
