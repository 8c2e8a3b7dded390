"""What a second worker saves where weights are shared: it scores a candidate while the next one trains.

One generation of the joint headset study, with one worker and with two, in turn; designs have to be equal::

    OMP_NUM_THREADS=1 python benchmarks/pipelined.py
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path
from typing import Any

from tacos_framework import load_recipe, run

STUDY = "headset_joint_quick"
POPULATION = 8


def timed(workers: int) -> dict[str, Any]:
    """The result of a generation evaluated by so many workers."""
    sets = {
        "optimizer.generations": 1,
        "optimizer.population": POPULATION,
        "study.train_best": 0,
        "compare": None,
        "test": None,
        "executor": {"use": "executor.process", "workers": workers},
    }
    with tempfile.TemporaryDirectory() as folder:
        return run(load_recipe(STUDY, sets), out=Path(folder) / "out", report=False)


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--times", type=int, default=1)
    times = parser.parse_args().times
    print(f"{'workers':>7} {'seconds':>8} {'training':>9} {'all work':>9}")
    for _ in range(times):
        designs = []
        for workers in (1, 2):
            result = timed(workers)
            spent = result["seconds_by_node"]
            training = sum(seconds for node, seconds in spent.items() if node.endswith("training"))
            print(
                f"{workers:>7} {result['seconds']:>8.0f} {training:>9.0f} {sum(spent.values()):>9.0f}",
                flush=True,
            )
            designs.append((result["best"]["camera"], result["best"]["fitness"]))
        assert designs[0] == designs[1], "workers changed the result"


if __name__ == "__main__":
    main()
