"""What a second worker saves where weights are shared: it scores a candidate while the next one trains.

The search of the joint headset study, cut short, with one worker and with two, in turn; designs have to be
equal. Beside the wall clock stand the processor time of all processes, how many of its seconds went by at
once, and in which parts they were spent::

    OMP_NUM_THREADS=1 LP_NUM_THREADS=1 python benchmarks/pipelined.py --times 2
"""

from __future__ import annotations

import argparse
import os
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tacos_framework import load_recipe, run

STUDY = "headset_joint_quick"


@dataclass(frozen=True)
class Timed:
    """A generation: its result, and the processor time of this process and of its workers [s]."""

    result: Mapping[str, Any]
    processor_s: float

    @property
    def row(self) -> str:
        """The figures of a table's row."""
        wall_s, spent = self.result["seconds"], self.result["seconds_by_node"]
        at_once = sum(spent.values()) / wall_s
        parts = "  ".join(
            f"{node} {seconds:.0f}" for node, seconds in sorted(spent.items()) if seconds >= 0.5
        )
        return f"{wall_s:>8.0f} {self.processor_s:>10.0f} {at_once:>8.2f}  {parts}"


def timed(workers: int, evaluations: int) -> Timed:
    """A search by so many workers, in worlds that nobody has built before."""
    sets = {
        "optimizer.evaluations": evaluations,
        "optimizer.starts": evaluations // 2,  # the rest in rounds, as most of a whole study
        "study.finalists": 1,
        "study.final_episodes": 1,
        "study.train_best": 0,
        "compare": None,
        "test": None,
        "executor": {"use": "executor.process", "workers": workers},
    }
    before = os.times()
    with tempfile.TemporaryDirectory() as folder:
        os.environ["TACOS_CACHE"] = str(Path(folder) / "cache")
        result = run(load_recipe(STUDY, sets), out=Path(folder) / "out", report=False)
    # User and system time, of this process and of the workers that have ended.
    return Timed(result, sum(now - then for now, then in zip(os.times()[:4], before[:4], strict=True)))


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--times", type=int, default=1, help="pairs of runs")
    parser.add_argument("--evaluations", type=int, default=8, help="candidates of the search")
    arguments = parser.parse_args()
    print(f"{'workers':>7} {'wall, s':>8} {'CPU, s':>10} {'at once':>8}  seconds by part")
    for _ in range(arguments.times):
        designs = []
        for workers in (1, 2):
            done = timed(workers, arguments.evaluations)
            print(f"{workers:>7} {done.row}", flush=True)
            designs.append((done.result["best"]["camera"], done.result["best"]["fitness"]))
        assert designs[0] == designs[1], "workers changed the result"


if __name__ == "__main__":
    main()
