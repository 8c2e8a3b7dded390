"""What a second worker saves where weights are shared: training, rendering ahead and scoring at a time.

The search of the joint headset study, cut short, with one worker and with two, in turn; designs have to be
equal. On an idle machine the clock tells::

    OMP_NUM_THREADS=1 LP_NUM_THREADS=1 python benchmarks/pipelined.py --times 2

On a busy one it does not. So each job's processor time is noted, with the worker that did it; a round of
jobs lasts as long as its busiest worker, and all rounds together are what the search would take where every
worker has a core of its own. Start of workers and the optimizer's own time count too.
"""

from __future__ import annotations

import argparse
import os
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tacos_framework import load_recipe, run
from tacos_plugins.executors.process import ProcessExecutor

STUDY = "headset_joint_quick"


@dataclass(frozen=True)
class Measured:
    """Does a job; gives the result, the process that did it, and its processor time [s]."""

    evaluate: Callable[[Any], Any]

    def __call__(self, job: Any) -> tuple[Any, int, float]:
        """Do it."""
        began_s = time.process_time()
        result = self.evaluate(job)
        return result, os.getpid(), time.process_time() - began_s


@dataclass
class MeasuringExecutor:
    """Worker processes, and what each spent in each round of jobs that were handed out together."""

    workers: int
    rounds: list[Counter[int]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._processes = ProcessExecutor(ProcessExecutor.Config(workers=self.workers))

    def map(self, evaluate: Callable[[Any], Any], jobs: Sequence[Any]) -> Iterator[Any]:
        """The results in the order of the jobs."""
        spent = Counter[int]()
        for result, process, seconds in self._processes.map(Measured(evaluate), jobs):
            spent[process] += seconds  # type: ignore[assignment]
            yield result
        self.rounds.append(spent)

    def close(self) -> None:
        """End the workers."""
        self._processes.close()

    @property
    def work_s(self) -> float:
        """Processor time of all jobs [s]."""
        return sum(spent.total() for spent in self.rounds)

    @property
    def path_s(self) -> float:
        """Processor time of the busiest worker of each round [s]."""
        return sum(max(spent.values(), default=0.0) for spent in self.rounds)


@dataclass(frozen=True)
class Timed:
    """A search: its result; processor time of its jobs, on the longest way, and beside them [s]."""

    result: Mapping[str, Any]
    work_s: float
    path_s: float
    beside_s: float

    @property
    def row(self) -> str:
        """The figures of a table's row."""
        spent = self.result["seconds_by_node"]
        parts = "  ".join(
            f"{node} {seconds / sum(spent.values()):.0%}"
            for node, seconds in sorted(spent.items(), key=lambda each: -each[1])
            if seconds >= 0.005 * sum(spent.values())
        )
        figures = self.result["seconds"], self.work_s, self.path_s + self.beside_s, self.work_s / self.path_s
        return "{:>8.0f} {:>8.1f} {:>8.1f} {:>8.2f}  ".format(*figures) + parts


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
    }
    executor = MeasuringExecutor(workers)
    with tempfile.TemporaryDirectory() as folder:
        os.environ["TACOS_CACHE"] = str(Path(folder) / "cache")
        began_s = time.process_time()
        result = run(load_recipe(STUDY, sets), out=Path(folder) / "out", report=False, executor=executor)
        beside_s = time.process_time() - began_s
        executor.close()
    return Timed(result, executor.work_s, executor.path_s, beside_s)


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--times", type=int, default=1, help="pairs of runs")
    parser.add_argument("--evaluations", type=int, default=8, help="candidates of the search")
    arguments = parser.parse_args()
    print(f"{'workers':>7} {'wall, s':>8} {'work, s':>8} {'path, s':>8} {'at once':>8}  share of each part")
    for _ in range(arguments.times):
        one, two = (timed(workers, arguments.evaluations) for workers in (1, 2))
        for workers, done in ((1, one), (2, two)):
            print(f"{workers:>7} {done.row}", flush=True)
        best = [(done.result["best"]["camera"], done.result["best"]["fitness"]) for done in (one, two)]
        assert best[0] == best[1], "workers changed the result"
        ratio = (one.path_s + one.beside_s) / (two.path_s + two.beside_s)
        clock = one.result["seconds"] / two.result["seconds"]
        print(f"two workers: {ratio:.2f} times as fast by processor time, {clock:.2f} by the clock")


if __name__ == "__main__":
    main()
