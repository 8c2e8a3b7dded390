"""How much of a study's wall time goes to the framework rather than to its components.

Runs the quick headset study in one process, without cameras off the shelf::

    LP_NUM_THREADS=1 OMP_NUM_THREADS=1 python benchmarks/framework_overhead.py --generations 3

The framework's share is all that is not spent inside a node: wiring, random generators,
the optimizer, checkpoints and logs. Loading Python's packages before the study is not in it.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

from tacos_framework import Recipe, read_any_recipe, run

QUICK = Path(__file__).parents[1] / "recipes" / "headset_quick.yaml"


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--generations", type=int, default=3)
    parser.add_argument("--binning", type=float, default=4)
    arguments = parser.parse_args()
    sets = {
        "executor": {"use": "executor.local"},
        "optimizer.generations": arguments.generations,
        "rig.binning": arguments.binning,
    }
    recipe, faults = read_any_recipe(QUICK, sets=sets)
    assert not faults, faults
    recipe = Recipe.model_validate({**recipe.as_data(), "compare": None})
    with tempfile.TemporaryDirectory() as folder:
        result = run(recipe, out=Path(folder) / "out", report=False)
    nodes = {name: spent for name, spent in result["seconds_by_node"].items() if name != "framework"}
    total = result["seconds"]
    for name, spent in sorted(nodes.items(), key=lambda entry: -entry[1]):
        print(f"{name:<10} {spent:>8.2f} s {100 * spent / total:>6.2f} %")
    outside = total - sum(nodes.values())
    print(f"{'framework':<10} {outside:>8.2f} s {100 * outside / total:>6.2f} %")
    print(f"{'in all':<10} {total:>8.2f} s for {result['frames_rendered']} images")


if __name__ == "__main__":
    main()
